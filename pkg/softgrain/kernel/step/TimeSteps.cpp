#include "step/TimeSteps.hpp"
#include "grain/CriticalTimeStep.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace softgrain {

template <int dim> void TimeSteps<dim>::followNewGrains()
{
	const int before = static_cast<int>(rate_.size());
	rate_.resize(grains_.count(), 1);
	ratesChosen_ = false;
	for (int g = before; g < grains_.count(); ++g)
		undeformed_ = std::min(undeformed_, stepOf(g, 1, 1));
}

template <int dim> void TimeSteps<dim>::measureUndeformed()
{
	undeformed_ = std::numeric_limits<double>::infinity();
	for (int g = 0; g < grains_.count(); ++g)
		undeformed_ = std::min(undeformed_, stepOf(g, 1, 1));
}

/// Critical step of a grain with its damping over its rate, s.
template <int dim>
double TimeSteps<dim>::stepOf(int g, double stiffening, double rateStiffening) const
{
	const GrainSet<dim>& set = grains_.setOf(g);
	const int k = grains_.indexInSet(g);
	return dampedTimeStep(set.criticalTimeStep(k), set.parameters(k).damping, stiffening,
			      rateStiffening) /
	       rate_[g];
}

template <int dim> double TimeSteps<dim>::presentStepOf(int g) const
{
	const GrainSet<dim>& set = grains_.setOf(g);
	const int k = grains_.indexInSet(g);
	return stepOf(g, set.stiffening(k), set.rateStiffening(k));
}

/// (They stay as they are.)
template <int dim> void TimeSteps<dim>::measureSleepers()
{
	if (sleepersMeasured_ == grains_.listsMade()) return;
	sleepersMeasured_ = grains_.listsMade();
	ofSleepers_ = std::numeric_limits<double>::infinity();
	for (int g : grains_.asleep())
		ofSleepers_ = std::min(ofSleepers_, presentStepOf(g));
}

template <int dim> double TimeSteps<dim>::deformed(double enough, int threads)
{
	measureSleepers();
	const double ofOthers = std::min(undeformed_, ofSleepers_);
	double shortest = ofOthers, known = std::min(enough, ofOthers);
	std::vector<std::pair<int, double>> due; // grains, and their steps before
	for (int g : grains_.active()) {
		const double own = presentStepOf(g);
		shortest = std::min(shortest, own);
		if (own >= known) continue;
		if (grains_.setOf(g).mayMeasureStiffening(grains_.indexInSet(g)))
			due.push_back({ g, own });
		else
			known = own;
	}
	std::vector<int> measured;
	for (const auto& [g, own] : due)
		if (own < known) measured.push_back(g);
	if (measured.empty()) return shortest;
	measure(measured, enough, threads);
	shortest = ofOthers;
	for (int g : grains_.active())
		shortest = std::min(shortest, presentStepOf(g));
	return shortest;
}

namespace {

/// Grains of one set that are measured side by side.
template <int dim> struct Lot {
	GrainSet<dim>* set;
	std::vector<DueMeasurement> due;
};

} // namespace

/// (All that have to be measured are so at once: which they are, and beside which others, does not
/// depend on threads.)
template <int dim>
void TimeSteps<dim>::measure(const std::vector<int>& grains, double enough, int threads)
{
	std::vector<Lot<dim>> lots;
	for (std::size_t begin = 0, end; begin < grains.size(); begin = end) {
		GrainSet<dim>* set = &grains_.setOf(grains[begin]);
		end = begin + 1;
		while (end < grains.size() && end - begin < laneWidth &&
		       &grains_.setOf(grains[end]) == set)
			++end;
		// fewer than what is computed side by side: each on its own, for as many threads
		if (end - begin < fullBlock) end = begin + 1;
		lots.push_back({ set, {} });
		for (std::size_t k = begin; k < end; ++k)
			lots.back().due.push_back(
				{ grains_.indexInSet(grains[k]), rate_[grains[k]] * enough });
	}
	const int count = static_cast<int>(lots.size());
	long points = 0;
#pragma omp parallel for schedule(dynamic) num_threads(threads) reduction(+ : points) if (count > 1)
	for (int k = 0; k < count; ++k) {
		const int forces = lots[k].set->measureStiffening(lots[k].due);
		points += static_cast<long>(forces) * lots[k].set->reference().points();
	}
	measuredPoints_ += points;
}

template <int dim> double TimeSteps<dim>::present(double enough, double bondRate, int threads)
{
	if (bondRate == 0) return deformed(enough, threads);
	// with the bonds T becomes T / sqrt(1 + T^2 w^2 / 4)
	auto quarter = [bondRate](double T) { return 0.25 * T * T * bondRate; };
	const double left = 1 - quarter(enough);
	const double infinity = std::numeric_limits<double>::infinity();
	const double ofGrains = deformed(left > 0 ? enough / std::sqrt(left) : infinity, threads);
	return ofGrains / std::sqrt(1 + quarter(ofGrains));
}

template <int dim> bool TimeSteps<dim>::setMultirate(bool on)
{
	if (ratesChosen_ && on == multirate_) return false;
	multirate_ = on;
	ratesChosen_ = true;
	rate_.assign(grains_.count(), 1);
	node_.clear();
	if (on) {
		std::vector<double> steps;
		for (int g = 0; g < grains_.count(); ++g) {
			steps.push_back(stepOf(g, 1, 1));
			node_.push_back(nodeOf(g));
		}
		rate_ = ratesOf(steps);
	}
	for (int g = 0; g < grains_.count(); ++g)
		grains_.setOf(g).setRate(grains_.indexInSet(g), rate_[g]);
	for (const auto& set : grains_.sets())
		set->arrangeGrains();
	measureUndeformed();
	sleepersMeasured_ = -1;
	return true;
}

template <int dim> typename TimeSteps<dim>::Node TimeSteps<dim>::nodeOf(int g) const
{
	const GrainSet<dim>& set = grains_.setOf(g);
	const int k = grains_.indexInSet(g);
	const GrainParameters<dim>& grain = set.parameters(k);
	const double dr = set.reference().pointSpacing() * grain.radius;
	const double mass = grain.constants.density * std::pow(dr, dim);
	return { mass, mass / std::pow(set.criticalTimeStep(k), 2) };
}

template <int dim> ForceInterval TimeSteps<dim>::intervalOf(int g) const
{
	return grains_.setOf(g).interval(grains_.indexInSet(g));
}

template <int dim> void TimeSteps<dim>::setInterval(int g, const ForceInterval& interval)
{
	grains_.setOf(g).setInterval(grains_.indexInSet(g), interval);
}

template <int dim>
void TimeSteps<dim>::followContacts(const std::vector<ContactList<dim>*>& lists, long step)
{
	if (!multirate_ || !ratesChosen_) return;
	for (const ContactList<dim>* list : lists) {
		if (list->contacts.empty()) continue;
		if (list->interface && list->interface->isBonded())
			for (int g : { list->first, list->second })
				if (g >= 0 && rate_[g] > 1) setInterval(g, { 1, step });
		if (list->second < 0) continue;
		followContact(list->first, list->second, step);
		followContact(list->second, list->first, step);
	}
	endShortIntervals(step);
}

/// (What it has through others ends with theirs: two that touch do not keep each other.)
template <int dim> void TimeSteps<dim>::followContact(int g, int other, long step)
{
	if (rate_[g] == 1) return;
	const ForceInterval own = intervalOf(g), its = intervalOf(other);
	const long met = its.steps < rate_[other] ? its.met : step;
	const bool isFaster = its.steps < own.steps;
	const bool isNews = its.steps == own.steps && own.steps < rate_[g] && met > own.met;
	if ((isFaster || isNews) && isShakenBy(g, other)) setInterval(g, { its.steps, met });
}

/// Where the other holds its nodes more stiffly, or is not lighter by much. (Small grains, which
/// are fast because they are light, may be touched.)
template <int dim> bool TimeSteps<dim>::isShakenBy(int g, int other) const
{
	// rounding, and grains that are all but alike
	constexpr double alike = 1.05;
	// what is light has less than half the critical step, or its rate would be the same; as
	// stiff, it has a quarter of the mass at most
	constexpr double light = 0.5;
	const Node &own = node_[g], &its = node_[other];
	return its.stiffness > alike * own.stiffness || its.mass > light * own.mass;
}

/// (Long after: each change of intervals changes what vibrations have for an energy.)
template <int dim> void TimeSteps<dim>::endShortIntervals(long step)
{
	constexpr long longWithout = 1000; // over the rate
	for (int g = 0; g < grains_.count(); ++g) {
		if (rate_[g] == 1) continue;
		const ForceInterval own = intervalOf(g);
		if (own.steps < rate_[g] && step - own.met > longWithout * rate_[g])
			setInterval(g, { rate_[g], own.met });
	}
}

/// Rates of grains with these critical steps: each divides the next, so that slow grains are
/// computed together.
template <int dim> std::vector<int> TimeSteps<dim>::ratesOf(const std::vector<double>& steps) const
{
	constexpr double rounding = 1e-9; // ten times as long is ten times, not nine
	std::vector<int> ascending(grains_.count());
	std::iota(ascending.begin(), ascending.end(), 0);
	std::stable_sort(ascending.begin(), ascending.end(),
			 [&](int a, int b) { return steps[a] < steps[b]; });
	std::vector<int> rates(grains_.count(), 1);
	int rate = 1;
	for (int g : ascending) {
		if (!grains_.setOf(g).mayHoldForces()) continue;
		const double shortest = steps[ascending.front()];
		rate *= std::max(1, static_cast<int>((1 + rounding) * steps[g] / shortest / rate));
		rates[g] = rate;
	}
	return rates;
}

template class TimeSteps<2>;
template class TimeSteps<3>;

} // namespace softgrain

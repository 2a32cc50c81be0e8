// Critical steps of the grains of a system, and steps of their own.
#pragma once

#include "contact/ContactList.hpp"
#include "step/Grains.hpp"

#include <limits>
#include <utility>
#include <vector>

namespace softgrain {

template <int dim> class TimeSteps {
public:
	/// Of these grains, which must outlive it.
	explicit TimeSteps(Grains<dim>& grains)
		: grains_(grains)
	{
	}
	/// After a set was added: its grains step as all do, until `setMultirate`.
	void followNewGrains();

	/// Smallest critical time step over the grains, undeformed, with their damping, s.
	double undeformed() const { return undeformed_; }
	/// The same as deformed now, and with bonds of this squared frequency (Interfaces); after
	/// the forces were computed. Grains that would make it shorter than `enough` are measured:
	/// what is longer than that may be too short.
	double present(double enough, double bondRate, int threads);
	/// Material points whose stress was computed for that since this was asked for last.
	long takeMeasuredPoints() { return std::exchange(measuredPoints_, 0); }

	/// Whether forces of grains with a longer critical step are computed in every so many steps
	/// only: as often as fits into their own undeformed critical step. To be called after all
	/// sets were added. False if nothing changes.
	bool setMultirate(bool on);
	/// In step number `step`: forces of slow grains are computed as often as those of stiffer,
	/// faster ones that they touch, or of grains like themselves which do; of bonded ones in
	/// every step, as bonds swing them faster than their own forces do.
	void followContacts(const std::vector<ContactList<dim>*>& lists, long step);
	/// Steps from one computation of the forces of a grain to the next, at most.
	int rate(int g) const { return rate_[g]; }

private:
	double stepOf(int g, double stiffening, double rateStiffening) const;
	double presentStepOf(int g) const;
	double deformed(double enough, int threads);
	void measure(const std::vector<int>& grains, double enough, int threads);
	void measureUndeformed();
	void measureSleepers();
	/// A node of a grain, to factors that all share.
	struct Node {
		double mass, stiffness; ///< kg, N/m
	};
	Node nodeOf(int g) const;
	ForceInterval intervalOf(int g) const;
	void setInterval(int g, const ForceInterval& interval);
	/// What a grain has from another that it touches.
	void followContact(int g, int other, long step);
	/// Whether forces of a grain must not be held while those of another, which it touches, are
	/// found more often.
	bool isShakenBy(int g, int other) const;
	void endShortIntervals(long step);
	std::vector<int> ratesOf(const std::vector<double>& steps) const;

	Grains<dim>& grains_;
	/// Critical steps of the undeformed grains and of the sleeping ones as deformed, the
	/// smallest, s.
	double undeformed_ = std::numeric_limits<double>::infinity(),
	       ofSleepers_ = std::numeric_limits<double>::infinity();
	long sleepersMeasured_ = -1; ///< Grains::listsMade then
	std::vector<int> rate_;      ///< by grain
	std::vector<Node> node_;     ///< by grain, if rates differ
	bool multirate_ = false, ratesChosen_ = false;
	long measuredPoints_ = 0; ///< not yet taken
};

} // namespace softgrain

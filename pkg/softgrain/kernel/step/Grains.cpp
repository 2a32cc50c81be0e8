#include "step/Grains.hpp"

#include <utility>

namespace softgrain {

template <int dim> void Grains<dim>::add(std::unique_ptr<GrainSet<dim>> set)
{
	renewLists();
	const int before = count();
	for (int k = 0; k < set->grains(); ++k)
		place_.push_back({ static_cast<int>(sets_.size()), k });
	loads_.resize(place_.size());
	sets_.push_back(std::move(set));
	for (int g = before; g < count(); ++g) // renewing all would be quadratic in sets
		appendToLists(g);
	sets_.back()->arrangeGrains();
	listedChanges_ += sets_.back()->changesOfActivity();
	++listsMade_;
}

template <int dim> void Grains<dim>::appendToLists(int g)
{
	listed_.push_back(listOf(g));
	if (listed_[g] == Listed::active) active_.push_back(g);
	(listed_[g] == Listed::asleep ? asleep_ : awake_).push_back(g);
}

template <int dim> typename Grains<dim>::Listed Grains<dim>::listOf(int g) const
{
	return isAsleep(g) ? Listed::asleep : isRigid(g) ? Listed::rigid : Listed::active;
}

template <int dim> void Grains<dim>::renewLists()
{
	long changes = 0;
	for (const auto& set : sets_)
		changes += set->changesOfActivity();
	if (listedChanges_ == changes && listed_.size() == place_.size()) return;
	listedChanges_ = changes;
	++listsMade_;
	listed_.clear();
	for (auto* list : { &active_, &asleep_, &awake_ })
		list->clear();
	for (int g = 0; g < count(); ++g)
		appendToLists(g);
	for (const auto& set : sets_)
		set->arrangeGrains();
}

template class Grains<2>;
template class Grains<3>;

} // namespace softgrain

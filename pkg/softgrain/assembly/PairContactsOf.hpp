// The contacts of a pair in a system of either dimension.
#pragma once

#include "assembly/PairContacts.hpp"
#include "step/System.hpp"

#include <string>

namespace softgrain {

template <int dim> class PairContactsOf : public PairContacts {
public:
	PairContactsOf(const System<dim>& system, double z)
		: system_(&system)
		, z_(z)
	{
	}
	bool isInUse() const override;
	bool isKept() const override { return list.isAsleep() && list.rest.kept; }
	double deepest() const override { return list.deepest; }
	void addMemory(MemoryPieces& memory) const override;
	void setFriction(double coefficient) override;
	void setInterface(const std::optional<InterfaceLaw>& law) override;
	void checkInterface() const override;
	int bondTouching() override;
	std::vector<double> interfaceHistory() const override
	{
		return list.interface ? list.interface->numbers() : std::vector<double>();
	}
	void restoreInterface(const std::vector<double>& saved) override;

	void setImageVelocity(const Vec3& velocity) override
	{
		list.image.velocity = toKernel<dim>(velocity);
	}
	void setPlaneVelocity(const Vec3& velocity) override
	{
		list.plane.velocity = toKernel<dim>(velocity);
	}

	bool hasRigidBody() const override { return list.rigid.has_value(); }
	void setPartner(int partner) override { list.rigid->partner = partner; }

	bool isOfTwoGrains() const override { return list.second >= 0; }
	int firstGrain() const override { return list.first; }
	void swapGrains() override;
	SumOfImpulses impulse() const override;

	std::vector<ContactRecord> records() const override;

	std::vector<ContactPressure> pressures() const override;
	double kick() const override
	{
		return list.isAsleep() ? list.rest.kick : system_->lastKick();
	}

	void restore(const std::vector<ContactRecord>& saved) override;

	OverlapAccount account() const override { return list.account; }
	void restoreAccount(const OverlapAccount& saved) override { list.account = saved; }

	std::vector<double> rest() const override;
	void restoreRest(const std::vector<double>& saved) override;
	void noteUnreadable(const std::string& what, std::size_t figures) override;

	ContactList<dim> list;

private:
	void seeImageFromSecond();
	/// Key and impulse. (All grains have contact of one kind; after loading it is not known yet
	/// which are of this pair.)
	Contact<dim> asSeenFromSecond(Contact<dim> c) const;

	/// Nodes of the common grid have other numbers once the grain has moved, and some get
	/// nothing any more: of these the mean contact point is told.
	Vec<dim> pointOnGrid(const Contact<dim>& c) const;

	/// A rigid body has no nodes: there it is the place that bears it.
	Vec<dim> pointOf(const Contact<dim>& c) const;

	const System<dim>* system_;
	double z_;
	bool lawUnknown_ = false; ///< history was restored, the law is still to come
	std::string unreadable_;  ///< what cannot be restored
};

static_assert((sizeof(PairContactsOf<2>) + 63) / 64 * 64 == PairContacts::size2D);

} // namespace softgrain

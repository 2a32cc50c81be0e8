// Vectors of the plane, one in every lane.
#pragma once

#include "Vector.hpp"
#include "lanes/LaneMath.hpp"

namespace softgrain {

inline Lanes withinUnit(const Lanes& t)
{
	return inEveryLane([&](int l) { return t[l] < 0 ? 0 : t[l] > 1 ? 1 : t[l]; });
}

/// With the names and the roundings of Vec<2>.
struct VectorLanes {
	using Scalar = Lanes;
	Lanes x, y;

	Lanes dot(const VectorLanes& o) const { return x * o.x + y * o.y; }
	Lanes squaredNorm() const { return dot(*this); }
	VectorLanes normalized() const
	{
		const Lanes length = sqrtOf(squaredNorm());
		return { x / length, y / length };
	}
};

inline VectorLanes operator+(const VectorLanes& a, const VectorLanes& b)
{
	return { a.x + b.x, a.y + b.y };
}
inline VectorLanes operator-(const VectorLanes& a, const VectorLanes& b)
{
	return { a.x - b.x, a.y - b.y };
}
inline VectorLanes operator*(const Lanes& s, const VectorLanes& v) { return { s * v.x, s * v.y }; }
inline VectorLanes operator*(double s, const VectorLanes& v) { return { s * v.x, s * v.y }; }
inline VectorLanes toTheRight(const VectorLanes& v) { return { v.y, -v.x }; }

} // namespace softgrain

#include "reference/Hourglass.hpp"

#include <algorithm>
#include <limits>
#include <optional>

namespace softgrain {

namespace {

/// Of the nine nodes about one, across axes `a` and `b`; none if one of them carries no unknowns.
template <int dim>
std::optional<double> lightestAbout(const BackgroundGrid<dim>& grid,
				    const typename BackgroundGrid<dim>::Index& middle, int a, int b,
				    const std::vector<double>& nodeMass)
{
	double lightest = std::numeric_limits<double>::infinity();
	for (int i = -1; i <= 1; ++i)
		for (int j = -1; j <= 1; ++j) {
			auto index = middle;
			index[a] += i;
			index[b] += j;
			const auto node = grid.number().find(index);
			if (node == grid.number().end()) return std::nullopt;
			lightest = std::min(lightest, nodeMass[node->second]);
		}
	return lightest;
}

} // namespace

template <int dim>
std::vector<HourglassStencil> hourglassStencils(const BackgroundGrid<dim>& grid,
						const PointLines<dim>& lines,
						const std::vector<double>& nodeMass, double kappa)
{
	std::vector<HourglassStencil> stencils;
	if (kappa == 0 || grid.order() < 2) return stencils;
	const double light =
		hourglassNodeShare * *std::max_element(nodeMass.begin(), nodeMass.end());
	for (const auto& [index, node] : grid.number())
		for (int b = 0; b < dim; ++b)
			for (int a = 0; a < b; ++a) {
				const auto lightest = lightestAbout(grid, index, a, b, nodeMass);
				if (!lightest || *lightest >= light) continue;
				const double area = grid.spacing()[a] * grid.spacing()[b];
				stencils.push_back({ lines.nodePlace[node],
						     { lines.stride[a], lines.stride[b] },
						     kappa * nodeMass[node] / area });
			}
	return stencils;
}

#define SOFTGRAIN_INSTANTIATE(dim)                                                                 \
	template std::vector<HourglassStencil> hourglassStencils<dim>(                             \
		const BackgroundGrid<dim>&, const PointLines<dim>&, const std::vector<double>&,    \
		double);
SOFTGRAIN_INSTANTIATE(2)
SOFTGRAIN_INSTANTIATE(3)
#undef SOFTGRAIN_INSTANTIATE

} // namespace softgrain

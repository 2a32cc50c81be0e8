#include "Helpers.hpp"
#include "material/Elasticity.hpp"

#include <catch2/catch_test_macros.hpp>
#include <limits>

using namespace softgrain;
using namespace softgrain::testing;

TEST_CASE("Elastic constants: Lame's constants and wave speeds", "[material]")
{
	const ElasticConstants c { 2e6, 0.3, 1500 };
	CHECK(std::abs(c.mu() / (2e6 / 2.6) - 1) < 1e-14);
	CHECK(std::abs(c.lambda() / (2e6 * 0.3 / (1.3 * 0.4)) - 1) < 1e-14);
	// Pressure waves: rho c^2 is the constrained modulus, in plane stress that of a plate.
	const double constrained = 2e6 * 0.7 / (1.3 * 0.4), plate = 2e6 / (1 - 0.09);
	CHECK(std::abs(c.waveSpeed(Condition::planeStrain) / std::sqrt(constrained / 1500) - 1) <
	      1e-14);
	CHECK(std::abs(c.waveSpeed(Condition::solid) / std::sqrt(constrained / 1500) - 1) < 1e-14);
	CHECK(std::abs(c.waveSpeed(Condition::planeStress) / std::sqrt(plate / 1500) - 1) < 1e-14);
}

TEST_CASE("Elastic constants: inadmissible values are named", "[material]")
{
	const double nan = std::numeric_limits<double>::quiet_NaN(),
		     inf = std::numeric_limits<double>::infinity();
	auto complaint = [](ElasticConstants c) { return complaintOf([&] { c.validate(); }); };
	CHECK(complaint({ 1e6, 0.45, 1000 }) == "");
	CHECK(complaint({ 1e6, -0.9, 1000 }) == "");
	CHECK(complaint({ 1e6, 0, 1000 }) == "");
	for (double nu : { 0.5, 0.6, -1., -1.5, nan }) {
		CAPTURE(nu);
		CHECK(complaint({ 1e6, nu, 1000 }).starts_with("poisson = "));
	}
	CHECK(complaint({ 1e6, 0.5, 1000 }).starts_with("poisson = 0.5 "));
	CHECK(complaint({ 1e6, 0.5, 1000 }).find("(-1, 0.5)") != std::string::npos);
	for (double young : { 0., -1e6, nan, inf })
		CHECK(complaint({ young, 0.45, 1000 }).starts_with("young = "));
	for (double density : { 0., -1., nan, inf })
		CHECK(complaint({ 1e6, 0.45, density }).starts_with("density = "));
}

TEST_CASE("Elasticity: names of laws and conditions", "[material]")
{
	CHECK(lawByName("neoHookean") == Law::neoHookean);
	CHECK(conditionByName("planeStrain") == Condition::planeStrain);
	CHECK(conditionByName("planeStress") == Condition::planeStress);
	const std::string law = complaintOf([] { lawByName("rubber"); });
	CHECK(law.find("'rubber'") != std::string::npos);
	CHECK(law.find("'neoHookean'") != std::string::npos);
	const std::string condition = complaintOf([] { conditionByName("flat"); });
	CHECK(condition.find("'flat'") != std::string::npos);
	CHECK(condition.find("'planeStress'") != std::string::npos);
}

// The one place where YADE's headers enter.
//
// Each REGISTER_SERIALIZABLE in a header of YADE instantiates that class once more in every
// translation unit. Here the macro that does it is empty while YADE's own headers are read, which
// cuts the size of our objects to a third; our own classes, declared afterwards, are registered as
// usual.
#pragma once

#include <lib/factory/ClassFactory.hpp>
#include <lib/serialization/Serializable.hpp>

#pragma push_macro("REGISTER_FACTORABLE")
#undef REGISTER_FACTORABLE
#define REGISTER_FACTORABLE(name)

#include <core/Aabb.hpp>
#include <core/Body.hpp>
#include <core/Clump.hpp>
#include <core/Dispatching.hpp>
#include <core/EnergyTracker.hpp>
#include <core/GlobalEngine.hpp>
#include <core/Interaction.hpp>
#include <core/InteractionContainer.hpp>
#include <core/InteractionLoop.hpp>
#include <core/Material.hpp>
#include <core/Omega.hpp>
#include <core/PartialEngine.hpp>
#include <core/Scene.hpp>
#include <core/Shape.hpp>
#include <core/State.hpp>
#include <core/TimeStepper.hpp>
#include <pkg/common/Box.hpp>
#include <pkg/common/ElastMat.hpp>
#include <pkg/common/Facet.hpp>
#include <pkg/common/ForceEngine.hpp>
#include <pkg/common/ForceResetter.hpp>
#include <pkg/common/GLDrawFunctors.hpp>
#include <pkg/common/InsertionSortCollider.hpp>
#include <pkg/common/MatchMaker.hpp>
#include <pkg/common/NormShearPhys.hpp>
#include <pkg/common/Sphere.hpp>
#include <pkg/common/TorqueEngine.hpp>
#include <pkg/common/Wall.hpp>
#include <pkg/dem/DemXDofGeom.hpp>
#include <pkg/dem/ElasticContactLaw.hpp>
#include <pkg/dem/FrictPhys.hpp>
#include <pkg/dem/Ig2_Box_Sphere_ScGeom.hpp>
#include <pkg/dem/Ig2_Facet_Sphere_ScGeom.hpp>
#include <pkg/dem/Ig2_Sphere_Sphere_ScGeom.hpp>
#include <pkg/dem/NewtonIntegrator.hpp>
#include <pkg/dem/PeriIsoCompressor.hpp>
#include <pkg/dem/ScGeom.hpp>
#include <pkg/dem/TriaxialStressController.hpp>

#pragma pop_macro("REGISTER_FACTORABLE")

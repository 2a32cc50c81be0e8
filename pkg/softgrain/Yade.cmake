# Finds an installed YADE and the headers of the same version, and derives from YADE's own configuration
# the compile definitions that decide how its classes are laid out in memory. Defines yade::host.

file(GLOB candidates
	"${YADE_PREFIX}/lib/*/yade-double/libyade.so"
	"${YADE_PREFIX}/lib/*/yade*/libyade.so"
	"${YADE_PREFIX}/lib/yade*/libyade.so")
if(NOT candidates)
	message(FATAL_ERROR "No libyade.so under ${YADE_PREFIX}/lib: set -DYADE_PREFIX= to where YADE is installed.")
endif()
list(FILTER candidates EXCLUDE REGEX "longdouble|float128|mpfr")
list(GET candidates 0 YADE_LIBRARY)
get_filename_component(YADE_LIB_DIR "${YADE_LIBRARY}" DIRECTORY)

file(READ "${YADE_LIB_DIR}/py/yade/config.py" config)
string(REGEX MATCH "\nversion *= *'([^']*)'" _ "${config}")
set(YADE_VERSION "${CMAKE_MATCH_1}")
string(REGEX MATCH "\nfeatures *= *'([^']*)'" _ "${config}")
separate_arguments(features UNIX_COMMAND "${CMAKE_MATCH_1}")
string(REGEX MATCH "highPrecisionBits *= *([0-9]+)" _ "${config}")
set(bits "${CMAKE_MATCH_1}")
string(REGEX MATCH "highPrecisionDecimalPlaces *= *([0-9]+)" _ "${config}")
set(digits "${CMAKE_MATCH_1}")
if(NOT bits EQUAL 64)
	message(FATAL_ERROR "YADE in ${YADE_LIB_DIR} computes with ${bits} bits; softgrain supports double precision (64) only.")
endif()

# The version of a source tree stands nowhere in its headers; the ChangeLog names it in its second line.
if(NOT EXISTS "${YADE_SOURCE_DIR}/core/Shape.hpp")
	message(FATAL_ERROR "YADE_SOURCE_DIR=${YADE_SOURCE_DIR} holds no core/Shape.hpp: give the root of YADE's source tree.")
endif()
file(STRINGS "${YADE_SOURCE_DIR}/ChangeLog" changelog LIMIT_COUNT 4)
string(REGEX MATCH "[0-9][0-9][0-9][0-9]\\.[0-9]+\\.[0-9]+[a-z]?" headerVersion "${changelog}")
if(NOT headerVersion STREQUAL YADE_VERSION)
	message(FATAL_ERROR "YADE in ${YADE_LIB_DIR} is version ${YADE_VERSION}, the headers in ${YADE_SOURCE_DIR} are of "
		"version '${headerVersion}': they must be the same.")
endif()
message(STATUS "YADE ${YADE_VERSION} in ${YADE_LIB_DIR}, headers in ${YADE_SOURCE_DIR}")

set(definitions YADE_REAL_BIT=${bits} YADE_REAL_DEC=${digits} MAX_LOG_LEVEL=4)
set(ofFeature_LOGGER YADE_BOOST_LOG BOOST_LOG_DYN_LINK)
set(ofFeature_OPENMP YADE_OPENMP)
set(ofFeature_QT5 YADE_OPENGL YADE_QT5 QT_NO_KEYWORDS)
set(ofFeature_MPI YADE_MPI)
set(ofFeature_FEMLIKE YADE_FEM)
set(ofFeature_LS_DEM YADE_LS_DEM)
set(ofFeature_COMPLEX_MP YADE_COMPLEX_MP)
set(ofFeature_MPFR YADE_MPFR)
set(ofFeature_SPH YADE_SPH)
set(ofFeature_DEFORM YADE_DEFORM)
set(ofFeature_LIQMIGRATION YADE_LIQMIGRATION)
set(ofFeature_MASK_ARBITRARY YADE_MASK_ARBITRARY)
set(ofFeature_POTENTIAL_PARTICLES YADE_POTENTIAL_PARTICLES)
set(ofFeature_PROFILING USE_TIMING_DELTAS ISC_TIMING)
foreach(feature IN LISTS features)
	list(APPEND definitions ${ofFeature_${feature}})
endforeach()
if(NOT "VECTORIZE" IN_LIST features)
	# These change the alignment of Eigen's types: everything that shares them with YADE must agree.
	set(YADE_EIGEN_DEFINITIONS EIGEN_DONT_VECTORIZE EIGEN_DONT_ALIGN EIGEN_DISABLE_UNALIGNED_ARRAY_ASSERT)
endif()

find_package(Python3 REQUIRED COMPONENTS Interpreter Development.Module)
find_package(Boost CONFIG REQUIRED COMPONENTS
	python${Python3_VERSION_MAJOR}${Python3_VERSION_MINOR} serialization iostreams log)

add_library(yade_host INTERFACE)
add_library(yade::host ALIAS yade_host)
target_compile_definitions(yade_host INTERFACE ${definitions})
target_include_directories(yade_host SYSTEM INTERFACE "${YADE_SOURCE_DIR}")
target_link_libraries(yade_host INTERFACE
	"${YADE_LIBRARY}" "${YADE_LIB_DIR}/libpkg_common.so" "${YADE_LIB_DIR}/libpkg_dem.so"
	Boost::python${Python3_VERSION_MAJOR}${Python3_VERSION_MINOR} Boost::serialization Boost::iostreams Boost::log
	Python3::Module Eigen3::Eigen OpenMP::OpenMP_CXX)
if("MPI" IN_LIST features)
	find_package(MPI REQUIRED COMPONENTS CXX) # for its headers only
	target_include_directories(yade_host SYSTEM INTERFACE ${MPI_CXX_INCLUDE_DIRS})
endif()

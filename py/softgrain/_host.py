"""Meeting with YADE: checks the host, registers the plugin's classes, refreshes the dispatchers."""

import os
import sys


def load_plugin():
    """Load the shared object into the running YADE.

    Returns:
        dict: the registered YADE classes by name.

    Raises:
        ImportError: there is no YADE, or it is not the one this plugin was built for.
    """
    try:
        import yade
        import yade.config
    except ImportError as error:
        raise ImportError(
            "softgrain is a plugin of YADE, which this Python does not find. Run the script with "
            "'yade script.py' (or scripts/yade), or put YADE's 'py' folder on PYTHONPATH, e.g. "
            "/usr/lib/x86_64-linux-gnu/yade-double/py"
        ) from error
    plugin = _import_shared_object()
    _check_version(plugin, yade.config)
    if not plugin.layoutMatches():
        raise ImportError(
            "softgrain was compiled for a YADE whose objects are laid out differently in memory "
            f"than those of the running one ({yade.config.libDir}). Rebuild softgrain against it "
            "(-DYADE_SOURCE_DIR=, -DYADE_PREFIX=)"
        )
    known = set(dir(yade.wrapper))
    plugin.registerClasses()
    names = [n for n in OWN_CLASSES if hasattr(yade.wrapper, n)]
    assert set(names) >= set(dir(yade.wrapper)) - known
    classes = {name: getattr(yade.wrapper, name) for name in names}
    vars(yade).update(classes)
    if hasattr(yade, "__all__"):
        yade.__all__ += [n for n in classes if n not in yade.__all__]
    main = sys.modules["__main__"]
    if hasattr(
        main, "O"
    ):  # a YADE script has the names of yade; those that came late are ours to add
        vars(main).update({n: c for n, c in classes.items() if not hasattr(main, n)})
    sys.modules["yade.softgrain"] = yade.softgrain = sys.modules["softgrain"]
    _refresh_dispatchers(yade.O)
    return classes


def replace_in_utils(name, function):
    """Put a function in the place of one of ``yade.utils``, also among the names of the script."""
    import yade.utils

    old = getattr(yade.utils, name)
    for module in (yade.utils, yade._utils, sys.modules["__main__"]):
        if getattr(module, name, None) is old:
            setattr(module, name, function)


#: Classes of YADE that are ours.
OWN_CLASSES = (
    "Bo1_SoftGrain_Aabb",
    "Gl1_SoftGrain",
    "Ig2_Box_SoftGrain_SoftGeom",
    "Ig2_Box_Sphere_ScGeom_Ahead",
    "Ig2_Facet_SoftGrain_SoftGeom",
    "Ig2_Facet_Sphere_ScGeom_Ahead",
    "Ig2_SoftGrain_SoftGrain_SoftGeom",
    "Ig2_Sphere_SoftGrain_SoftGeom",
    "Ig2_Sphere_Sphere_ScGeom_Ahead",
    "Ig2_Wall_SoftGrain_SoftGeom",
    "Ig2_Wall_Sphere_ScGeom_Ahead",
    "Ip2_FrictMat_SoftMat_SoftPhys",
    "Ip2_SoftMat_SoftMat_SoftPhys",
    "Ip2_SoftPhys",
    "Law2_ScGeom_FrictPhys_Nonsmooth",
    "Law2_SoftGeom_SoftPhys_Nonsmooth",
    "SoftGeom",
    "SoftGrain",
    "SoftGrainIntegrator",
    "SoftInterface",
    "SoftMat",
    "SoftPhys",
    "SoftenWhenLoaded",
    "WallStressController",
)


def _import_shared_object():
    # vtables, type information and boost::serialization's singletons are shared with YADE's
    # libraries
    flags = sys.getdlopenflags()
    sys.setdlopenflags(os.RTLD_NOW | os.RTLD_GLOBAL)
    try:
        from softgrain import _softgrain
    finally:
        sys.setdlopenflags(flags)
    return _softgrain


def _check_version(plugin, config):
    built_for = (plugin.yadeVersion, plugin.yadeBits)
    running = (config.version, config.highPrecisionBits)
    if built_for != running:
        raise ImportError(
            f"softgrain was built for YADE {built_for[0]} with {built_for[1]}-bit numbers, the "
            f"running one is YADE {running[0]} with {running[1]}-bit numbers. Rebuild softgrain "
            "with -DYADE_SOURCE_DIR= of that version"
        )


def _refresh_dispatchers(omega):
    """Resize the dispatch tables of the present engines for the new classes."""
    for engine in omega.engines:
        for name in ("boundDispatcher", "geomDispatcher", "physDispatcher", "lawDispatcher"):
            dispatcher = getattr(engine, name, None)
            if dispatcher is not None:
                dispatcher.functors = dispatcher.functors

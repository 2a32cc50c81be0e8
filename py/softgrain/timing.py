"""Where the time of a run goes, phase by phase, out of YADE's own books."""

import yade.timing
from yade import InteractionLoop, O


def reset_times():
    """Zero YADE's books, as ``yade.timing.reset()``, which leaves out functors in an
    ``InteractionLoop`` and with them the search."""
    yade.timing.reset()
    for engine in O.engines:
        for functor in _searching(engine):
            functor.timingDeltas.reset()


def phase_times():
    """Wall time of each phase since :func:`reset_times`, while ``O.timingEnabled``.

    Phases bear the names of the functions that do them (doc/architecture.md, "The step"); they do
    not overlap, and add up to the time of all engines. An engine without phases of its own is one
    phase with the name of its class; what an engine spends outside its phases has that name too.
    The search, *findContacts*, is part of the ``InteractionLoop``: its times in all threads, over
    the number of threads.

    Returns:
        dict: name to (seconds, number of times), in the order of ``O.engines``.
    """
    table = {}
    for engine in O.engines:
        rest = engine.execTime
        for name, nanoseconds, count in _details(engine):
            rest -= nanoseconds
            _add(table, name, nanoseconds, count)
        _add(table, type(engine).__name__, max(rest, 0), engine.execCount)
    return table


def _details(engine):
    """(name, nanoseconds, count) of the phases of ours in an engine."""
    searching = _searching(engine)
    if searching:
        threads = engine.ompThreads if engine.ompThreads > 0 else O.numThreads
        lines = [line for functor in searching for line in functor.timingDeltas.data]
        nanoseconds = sum(line[1] for line in lines) / min(threads, O.numThreads)
        return [("findContacts", nanoseconds, sum(line[2] for line in lines))]
    if type(engine).__name__ == "SoftGrainIntegrator":
        return engine.timingDeltas.data
    return []


def _searching(engine):
    """Ig2 functors of ours in an engine."""
    functors = engine.geomDispatcher.functors if isinstance(engine, InteractionLoop) else []
    return [f for f in functors if type(f).__name__.endswith("SoftGrain_SoftGeom")]


def _add(table, name, nanoseconds, count):
    seconds, times = table.get(name, (0.0, 0))
    table[name] = (seconds + 1e-9 * nanoseconds, times + count)

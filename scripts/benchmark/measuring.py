"""What a benchmark measures of a step: time by phase, counted work, memory."""

import resource
import statistics
import time
from pathlib import Path

from yade import O

import softgrain as sg

COUNTS = (
    "totalSweeps",
    "pointsUpdated",
    "pointsMeasured",
    "pairsSearched",
    "candidatesTested",
    "contactsSwept",
)


def measure(options):
    """Figures of a step: medians over the repetitions."""
    O.timingEnabled = True
    return medians([_repetition(options.steps) for _ in range(options.repeat)])


def _repetition(steps):
    sg.reset_times()
    before = counted_work()
    wall, processor = time.perf_counter(), time.process_time()
    sg.advance(steps)
    wall, processor = time.perf_counter() - wall, time.process_time() - processor
    return figures_of(steps, wall, processor, before)


def figures_of(steps, wall, processor, before):
    """Figures of each of the steps since the books were reset and ``before`` was counted.

    Phases are booked in wall time. ``busy`` is the share of it in which this process had the
    processor; what other programs took is left out of all phases alike. With several threads that
    is not known, and taken as 1.
    """
    after = counted_work()
    busy = min(processor / wall, 1) if O.numThreads == 1 else 1.0
    times = {name: seconds for name, (seconds, _) in sg.phase_times().items()}
    times["outside the engines"] = max(wall - sum(times.values()), 0)
    return {
        "wall": wall / steps,
        "busy": busy,
        "phases": {name: busy * seconds / steps for name, seconds in times.items()},
        "counts": {name: (after[name] - before[name]) / steps for name in after},
    }


def counted_work():
    """What the integrator has counted so far, by name; nothing in a scene without one."""
    try:
        engine = sg.integrator()
    except ValueError:
        return {}
    return {name: getattr(engine, name) for name in COUNTS}


def medians(rows):
    """Medians of nested dicts of numbers, key by key; a phase that a row lacks took no time."""
    if not isinstance(rows[0], dict):
        return statistics.median(rows)
    keys = dict.fromkeys(key for row in rows for key in row)
    return {key: medians([row.get(key, 0.0) for row in rows]) for key in keys}


def peak_memory():
    """Of this process so far [bytes]."""
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def resident_memory():
    """Of this process now [bytes]."""
    return resource.getpagesize() * int(Path("/proc/self/statm").read_text().split()[1])

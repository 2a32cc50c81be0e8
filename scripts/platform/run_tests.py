#!/usr/bin/env python3
"""Run every test and check, and end with one line of totals.

Called by ``scripts/test`` on the platform, in the top folder of the checkout, as
``run_tests.py BUILD built|broken [PYTEST OPTIONS]``.
"""

import os
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree


def main(build, build_state, pytest_options):
    """Run all parts, whatever becomes of the others, and return the exit code."""
    totals = Counter(passed=0, failed=0)
    totals += check("format", ["clang-format", "--dry-run", "-Werror", *cpp_files()])
    totals += check("lint", ["flake8", "py", "scripts", "tests"])
    if build_state == "built":
        totals += kernel_tests(build)
        totals += python_tests(build, pytest_options)
    else:
        print("\n== build\nbroken: the tests cannot run")
        totals["failed"] += 1
    print(summary(totals))
    return 1 if totals["failed"] else 0


def kernel_tests(build):
    """CTest, which knows the Catch2 tests of the kernel."""
    return reported(
        "kernel tests",
        lambda report: [
            "ctest",
            "--test-dir",
            build,
            "--output-on-failure",
            "--parallel",
            str(os.cpu_count()),
            "--output-junit",
            report,
        ],
    )


def python_tests(build, options):
    """Pytest: Python, and scenes inside YADE. A later -m or path among the options wins.

    A process for each processor, with one thread unless a test asks for more: threads of several
    processes would wait for each other's processors.
    """
    return reported(
        "python tests",
        lambda report: [
            "env",
            "OMP_NUM_THREADS=1",
            "python3",
            "-m",
            "pytest",
            "-o",
            "testpaths=tests",
            "-o",
            f"cache_dir={build}/pytest_cache",
            "-m",
            "not slow",
            "--numprocesses=auto",
            "--dist=loadfile",  # so that fixtures of a module are made once
            f"--junitxml={report}",
            *options,
        ],
        no_test_code=5,
    )


def reported(title, command, no_test_code=0):
    """Run a command that reports in JUnit's format, and count its tests.

    A command that ends badly with no failed test in its report (a crash) counts as one failure.
    """
    print(f"\n== {title}", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        report = os.path.join(folder, "report.xml")
        code = subprocess.run(command(report)).returncode
        totals = read_report(report)
    if code not in (0, no_test_code) and not totals["failed"]:
        print(f"{title} ended with exit code {code}")
        totals["failed"] += 1
    return totals


def read_report(path):
    """Count the tests of a JUnit report; none if there is no report."""
    totals = Counter()
    if os.path.exists(path) and os.path.getsize(path):
        for suite in ElementTree.parse(path).getroot().iter("testsuite"):
            failed = int(suite.get("failures", 0)) + int(suite.get("errors", 0))
            skipped = int(suite.get("skipped", 0)) + int(suite.get("disabled", 0))
            totals["failed"] += failed
            totals["skipped"] += skipped
            totals["passed"] += int(suite.get("tests", 0)) - failed - skipped
    return totals


def check(title, command):
    """Run a check, which counts as one test."""
    print(f"\n== {title}", flush=True)
    passed = subprocess.run(command).returncode == 0
    print("passed" if passed else "failed", flush=True)
    return Counter(passed=1) if passed else Counter(failed=1)


def cpp_files():
    """List the C++ files that are formatted by rule."""
    return sorted(
        str(path)
        for folder in ("pkg", "scripts", "tests")
        for suffix in ("cpp", "hpp")
        for path in Path(folder).rglob(f"*.{suffix}")
    )


def summary(totals):
    """Return the last line."""
    line = f"\n{totals['passed']} passed, {totals['failed']} failed"
    return line + (f", {totals['skipped']} skipped" if totals["skipped"] else "")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2], sys.argv[3:]))

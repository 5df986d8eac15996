"""Profile of a scenario by function and by line: python benchmarks/hotspots.py B.

The processor is sampled with `perf` of Linux while the engine simulates. The source of each sample
is found from the line numbers in the machine code, including inlined functions. For this the engine
is compiled with line numbers into a separate cache folder, which takes a minute or two the first
time and does not change its speed. Needs `perf` and binutils.
"""

from __future__ import annotations

import argparse
import collections
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

WITH_LINES = "NUMBA_DEBUGINFO"
SAMPLES_PER_SECOND = 997
CODE_SECTION = ".ltext"
"""Section of numba's object files with the machine code."""

_DEMANGLED = re.compile(r"abradem::dem::(\w+)::(\w+)\[")
_MANGLED = re.compile(r"^_ZN7abradem3dem\d+([a-z_]+?)(\d+)(\w+)")


KEPT: dict[int, bytes] = {}
"""Machine code from numba's cache by library; numba itself drops it after loading."""


def keep_cached_code() -> None:
    """Make numba's libraries store the code that they load from the cache in `KEPT`."""
    from numba.core.codegen import CodeLibrary

    put = CodeLibrary._set_compiled_object

    def put_and_keep(library, data):
        KEPT[id(library)] = data
        put(library, data)

    CodeLibrary._set_compiled_object = put_and_keep


def compiled_kernels():
    """Yield for each kernel the object file (bytes), the name of its function and the address."""
    import abradem.dem

    folder = Path(abradem.dem.__file__).parent
    for name in sorted(path.stem for path in folder.glob("*.py")):
        module = sys.modules.get(f"abradem.dem.{name}")
        for kernel in vars(module).values() if module else ():
            if getattr(kernel, "__module__", None) != f"abradem.dem.{name}":
                continue
            for overload in getattr(kernel, "overloads", {}).values():
                library, function = overload.library, overload.fndesc.llvm_func_name
                # numba has no public access to the machine code of a library.
                address = library._codegen._engine._ee.get_function_address(function)
                data = KEPT.get(id(library)) or library._compiled_object
                if data is not None:
                    yield data, function, address


def placed_code(folder: Path):
    """Write the object files; return (path, start address of the code, size) of each."""
    placed = {}
    for data, function, address in compiled_kernels():
        path = folder / f"{len(placed)}.o"
        path.write_bytes(data)
        symbols = output("nm", str(path)).splitlines()
        offset = next((int(s.split()[0], 16) for s in symbols if s.endswith(f" {function}")), None)
        if offset is None or address == 0:
            continue
        sections = [line.split() for line in output("objdump", "-h", str(path)).splitlines()]
        size = next(int(row[2], 16) for row in sections if row[1:2] == [CODE_SECTION])
        placed[address - offset] = (path, size)
    return [(path, start, size) for start, (path, size) in placed.items()]


def output(*command: str) -> str:
    """Return the output of a program."""
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def function_name(symbol: str) -> str:
    """Return ``module.function`` of the engine, or "" for functions of numba."""
    if found := _DEMANGLED.search(symbol):
        return f"{found[1]}.{found[2]}"
    if found := _MANGLED.match(symbol):
        return f"{found[1]}.{found[3][: int(found[2])]}"
    return ""


def chains(samples, code):
    """Yield (count, [(function, file:line), ...]), innermost function first."""
    by_file = collections.defaultdict(collections.Counter)
    for address in samples:
        for path, start, size in code:
            if start <= address < start + size:
                by_file[path][address - start] += 1
                break
        else:
            yield 1, [("outside the engine", "")]
    for path, counts in by_file.items():
        offsets = [hex(offset) for offset in counts]
        lines = output(
            "addr2line", "-e", str(path), "-j", CODE_SECTION, "-f", "-i", "-C", "-a", *offsets
        ).splitlines()
        found, current = {}, None
        for line in lines:
            if line.startswith("0x"):
                current = found[int(line, 16)] = []
            else:
                current.append(line)
        for offset, count in counts.items():
            pairs = zip(found[offset][::2], found[offset][1::2], strict=True)
            named = [(function_name(name), Path(place).name) for name, place in pairs]
            chain = [(name, place) for name, place in named if name]
            yield count, chain or [("outside the engine", "")]


def sampling(data: Path) -> subprocess.Popen:
    """Start `perf` on this process and wait until it samples."""
    perf = subprocess.Popen(
        ["perf", "record", "-q", "-o", str(data), "-e", "cpu-clock",
         "-F", str(SAMPLES_PER_SECOND), "-p", str(os.getpid())]
    )  # fmt: skip
    time.sleep(1.0)
    return perf


def record(scenario: str, seconds: float | None, stepping: str, after: float | None):
    """Simulate a scenario under `perf` and print the shares of functions and lines."""
    from dataclasses import replace

    from speed import SCENARIOS, timed

    from abradem.dem import simulate
    from abradem.dem.warm import warm

    keep_cached_code()
    warm()
    chosen = SCENARIOS[scenario]
    setup = replace(chosen.setup, stepping=stepping)
    if seconds is not None:
        setup = replace(setup, duration=seconds)
    if after is not None and after >= setup.duration:
        raise SystemExit(f"--after {after:g} s; less than the duration of {setup.duration:g} s")
    with tempfile.TemporaryDirectory() as folder:
        code = placed_code(Path(folder))
        data = Path(folder, "perf.data")
        if after is None:
            perf = sampling(data)
            spent, result = timed(chosen.case, setup)
            while spent.cpu < 1.0:
                more, result = timed(chosen.case, setup)
                spent = spent._replace(cpu=spent.cpu + more.cpu)
        else:
            started: list[subprocess.Popen] = []

            def progress(now: float) -> None:
                if now >= after and not started:
                    started.append(sampling(data))

            result = simulate(chosen.case, setup, progress=progress)
            (perf,) = started
        perf.send_signal(signal.SIGINT)
        perf.wait()
        script = output("perf", "script", "-i", str(data), "-F", "ip")
        samples = [int(line, 16) for line in script.split() if line]
        found = list(chains(samples, code))
    print(
        f"{scenario}, {stepping}: {after or 0:g} to {result.simulated_time:g} s simulated, "
        f"{len(samples)} samples"
    )
    print_shares(found)


def print_shares(found) -> None:
    """Print the share of each function, alone and with inlined functions, and of each line."""
    alone, within, lines = (collections.Counter() for _ in range(3))
    for count, chain in found:
        alone[chain[0][0]] += count
        for name in {name for name, _ in chain}:
            within[name] += count
        lines[" < ".join(place for _, place in chain[:3])] += count
    total = sum(alone.values())
    print(f"{'within %':>9} {'alone %':>8}  function")
    for name, count in within.most_common(30):
        print(f"{100 * count / total:9.1f} {100 * alone[name] / total:8.1f}  {name}")
    print(f"{'%':>9}  line")
    for place, count in lines.most_common(30):
        print(f"{100 * count / total:9.1f}  {place}")


def main() -> None:
    """Start a process with an engine that has line numbers, and profile it."""
    parser = argparse.ArgumentParser(description="profile of a scenario by function and by line")
    parser.add_argument("scenario", help="one of A, M, B, D, E, F")
    parser.add_argument("--seconds", type=float, help="duration instead of that of the scenario, s")
    parser.add_argument("--stepping", default="islands", help="islands or synchronous")
    parser.add_argument("--after", type=float, help="sample from this simulated time on only, s")
    chosen = parser.parse_args()
    for program in ("perf", "addr2line", "nm", "objdump"):
        if not shutil.which(program):
            raise SystemExit(f"{program} is not installed (Debian: linux-perf, binutils)")
    if os.environ.get(WITH_LINES) != "1":
        from abradem.dem.cache import cache_folder

        environment = os.environ | {
            WITH_LINES: "1",
            "ABRADEM_CACHE_DIR": str(cache_folder().parent / "with-lines"),
        }
        raise SystemExit(subprocess.run([sys.executable, *sys.argv], env=environment).returncode)
    record(chosen.scenario, chosen.seconds, chosen.stepping, chosen.after)


if __name__ == "__main__":
    main()

"""How often the 95 % intervals of cases that the stop rule ended hold the true rate.

    python benchmarks/stops.py                       # 8 minutes of computing
    python benchmarks/stops.py --corners 0 1 --seeds 1000

Records of a fixed length are simulated with many seeds, and the stop rule is replayed on them (the
engine ends at the same sample, tests/dem/test_stop.py). The true rate is the mean of all records
over whole release intervals. The interval is the rate -+ Student's t, of the degrees of freedom of
the standard error, times that error. Beside the rule: a stop at the first standard error at
the target, from 20 batches that do not regard the releases.
"""

from __future__ import annotations

import argparse
import math

import numpy as np
from scipy import stats

from abradem.dem.steady import batch_means
from abradem.dem.stop import CHECK_GROWTH, StopRule
from abradem.verification.jets import JET, jet_case, run_jet
from abradem.verification.stop_rule import long_rate

CORNERS = (
    ("R 40 mm, 8 deg", {"particle_radius": 0.04, "plate_angle": 8.0}, 60.0, 300),
    ("R 40 mm, 60 deg", {"particle_radius": 0.04, "plate_angle": 60.0}, 60.0, 300),
    ("R 10 mm, 8 deg", {"particle_radius": 0.01, "plate_angle": 8.0}, 10.0, 30),
    ("R 10 mm, 60 deg", {"particle_radius": 0.01, "plate_angle": 60.0}, 20.0, 300),
    ("R 40 mm, 8 deg, e 0.8, factory -60 deg",
     {"particle_radius": 0.04, "plate_angle": 8.0, "restitution": 0.8, "factory_angle": -60.0},
     60.0, 300),
)  # fmt: skip
"""Name, changes of the case, length of the records, s, and number of seeds."""


def by_the_rule(setup, time, worn, present, release_interval):
    """Rate, standard error, its freedom and end of a record by the stop rule."""
    rule = StopRule(setup, time[1], release_interval)
    past = slice(len(time))
    while rule.next_look < len(time):
        look = slice(rule.next_look + 1)
        if rule.ends(time[look], worn[look], present[look]):
            past = look
            break
    steady = rule.steady(time[past], worn[past], present[past])
    return steady.rate, steady.relative_stderr * steady.rate, steady.freedom, time[past][-1]


def by_the_first_look(setup, time, worn, present, release_interval):
    """The same if the first small standard error ends the case, whatever the releases."""
    rule = StopRule(setup, time[1], release_interval)
    sample = rule.next_look
    while True:
        sample = min(sample, len(time) - 1)
        past = slice(sample + 1)
        steady = rule.steady(time[past], worn[past], present[past])
        found = batch_means(time[past], worn[past], steady.start)
        complete = steady.settled and steady.complete(sample // rule.map_samples + 1)
        small = complete and found.stderr <= setup.target_stderr * found.rate
        if small or sample == len(time) - 1:
            return found.rate, found.stderr, found.freedom, time[sample]
        if complete:
            sample = max(sample + 1, math.ceil(CHECK_GROWTH * sample))
        else:
            sample += rule.map_samples


def line(name: str, ended, truth: float, truth_error: float) -> str:
    """One line of the table: end, bias and coverage with their standard errors."""
    rate, stderr, freedom, end = np.array(ended).T
    reach = stats.t.ppf(0.975, freedom) * stderr
    count = len(rate)
    bias = 100.0 * (rate.mean() / truth - 1.0)
    bias_error = 100.0 * math.hypot(rate.std(ddof=1) / math.sqrt(count), truth_error) / truth
    held = float((np.abs(rate - truth) <= reach).mean())
    low, high = stats.binom.ppf([0.025, 0.975], count, 0.95) / count
    return (
        f"| {name} | {count} | {end.mean():.1f} | {bias:+.2f} ± {bias_error:.2f} | "
        f"{100 * math.sqrt((stderr**2).mean()) / truth:.2f} | "
        f"{100 * rate.std(ddof=1) / truth:.2f} | {100 * held:.1f} | "
        f"{100 * low:.1f} to {100 * high:.1f} |"
    )


def main() -> None:
    """Print the table of all corners."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--corners", type=int, nargs="+", default=range(len(CORNERS)))
    parser.add_argument("--seeds", type=int, help="for each corner, instead of its own number")
    chosen = parser.parse_args()
    setup = JET.setup()
    print(
        "| case, rule | records | end, s | bias, % | stated error, % | spread, % | held, % | band |"
    )
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: | --- |")
    for number in chosen.corners:
        name, changes, duration, seeds = CORNERS[number]
        rates, ended, first = [], [], []
        for seed in range(chosen.seeds or seeds):
            result = run_jet(jet_case(seed=seed, **changes), JET.setup(duration=duration))
            record = (result.time, result.worn[:, 0], result.present, result.release_interval)
            rates.append(long_rate(result))
            ended.append(by_the_rule(setup, *record))
            first.append(by_the_first_look(setup, *record))
        truth = float(np.mean(rates))
        truth_error = float(np.std(rates, ddof=1) / math.sqrt(len(rates)))
        print(line(f"{name}: the rule", ended, truth, truth_error))
        print(line(f"{name}: first look", first, truth, truth_error), flush=True)


if __name__ == "__main__":
    main()

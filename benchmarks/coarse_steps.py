"""What a step that hardly resolves a contact does to the wear, and which cases it is refused for.

    python benchmarks/coarse_steps.py                  # table of the bias, cases refused: a minute
    python benchmarks/coarse_steps.py --jets           # whole jets beside their first impact

The first table has the largest bias of ``total`` and ``friction`` over the angles of impact, by
the steps of a contact at full speed and the restitution. The second one counts the cases of a study
that the engine refuses because of their step, for several steps and fall heights. The third one
compares the bias of a whole jet with that of its first impact, by which the engine judges.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from abradem.config import read_config, sampled_ranges, setup_dict
from abradem.dem.impact import step_bias
from abradem.dem.model import Case, ContactModel, Setup
from abradem.dem.simulation import (
    FEWEST_STEPS_PER_CONTACT,
    JUDGED_ANGLES,
    LARGEST_STEP_BIAS,
)
from abradem.elastic import hertz_duration
from abradem.sampling.draw import block_cases
from abradem.verification.jets import JET, run_jet
from abradem.verification.scenes import Scene

ROOT = Path(__file__).parents[1]
STEPS = (5.0, 6.0, 8.0, 10.0, 12.0, 14.0, 16.0, 18.0, 20.0, 30.0)
RESTITUTIONS = (0.05, 0.07, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.95, 1.0)
ANGLES = (10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0)
SPEED = 5.0
ROLLING_FRICTIONS = (0.0, 0.05, 0.1)


def whole_contact(case: Case, speed: float) -> float:
    """Return the duration of a head-on elastic impact on the plate, s."""
    from abradem.dem.state import make_problem

    problem, _ = make_problem(case, Setup(time_step=1.0))
    return float(hertz_duration(problem.plate_law.kn, problem.mass, speed))


def print_biases(contact: ContactModel) -> None:
    """Print the largest bias over the angles by restitution and steps per contact."""
    print("largest bias (%) of total / friction over angles and rolling frictions of 0 to 0.1")
    print("   e" + "".join(f"{steps:>16g}" for steps in STEPS) + "  steps per contact")
    for e in RESTITUTIONS:
        cases = [
            Scene().with_interaction(restitution=e, rolling_friction=mu_r).case()
            for mu_r in ROLLING_FRICTIONS
        ]
        whole, cells = whole_contact(cases[0], SPEED), []
        for steps in STEPS:
            found = [
                step_bias(case, contact, whole / steps, SPEED, angle)
                for case in cases
                for angle in ANGLES
            ]
            worst = (100.0 * max(abs(one[name]) for one in found) for name in ("total", "friction"))
            cells.append("{:8.1f} /{:6.1f}".format(*worst))
        print(f"{e:4.2f}" + "".join(cells))


def print_refused(config_file: Path) -> None:
    """Print how many cases of a study are refused because of their step."""
    config = read_config(config_file)
    ranges, plain = sampled_ranges(config), Setup.from_dict(setup_dict(config))
    sampling = config.sampling
    cases = [
        Case.from_row(row)
        for block in range(sampling.blocks)
        for row in block_cases(
            config.seed, block, sampling.cases_per_block, sampling.method, ranges
        ).to_dict("records")
    ]
    print(f"\n{config_file.name}: of {len(cases)} cases are refused, with the largest bias")
    # From 3.1 m on, particles thrown at 10 m/s arrive 2.5 m/s faster.
    for height in (plain.fall_height, 3.1):
        for fraction in (0.15, 0.2, 0.25, 0.3):
            setup = replace(plain, fall_height=height, time_step_fraction=fraction)
            found = [(*judged(case, setup), case) for case in cases]
            refused = [
                bias for steps, bias, _ in found
                if steps < FEWEST_STEPS_PER_CONTACT or bias > LARGEST_STEP_BIAS
            ]  # fmt: skip
            print(
                f"  fall height {height:g} m, step {fraction:g}: {len(refused)} refused; fewest "
                f"steps {min(one[0] for one in found):.1f}, largest bias "
                f"{100.0 * max(one[1] for one in found):.1f} %",
                flush=True,
            )


def judged(case: Case, setup: Setup) -> tuple[float, float]:
    """Return the steps of a head-on contact and the largest bias of the first impact."""
    speed = (case.particle_velocity_y**2 + 2.0 * setup.gravity * setup.fall_height) ** 0.5
    step = setup.time_step_fraction * case.particle.rayleigh_time(case.particle_radius)
    low, high = JUDGED_ANGLES
    angle = min(max(abs(case.plate_angle), low), high)
    found = step_bias(case, setup.contact, step, speed, angle)
    return whole_contact(case, speed) / step, max(map(abs, found.values()))


def print_jets(seeds: int = 4, duration: float = 10.0) -> None:
    """Print the bias of total and friction of dilute jets beside that of their first impact."""
    print("\nbias (%) of total / friction: first impact, whole jet")
    for e, steps in ((0.07, 10.0), (0.2, 9.0), (0.5, 9.0), (0.5, 12.0), (0.8, 7.0)):
        for angle in (25.0, 45.0):
            case = JET.case(plate_angle=angle, particle_velocity_y=-8.0, restitution=e)
            setup = JET.setup(mass_rate=None, number_rate=20.0, duration=duration)
            speed = (64.0 + 2.0 * setup.gravity * setup.fall_height) ** 0.5
            whole = whole_contact(case, speed)
            first = step_bias(case, setup.contact, whole / steps, speed, angle)
            worn = {}
            for n in (steps, 100.0):
                runs = [
                    run_unjudged(replace(case, seed=seed), replace(setup, time_step=whole / n))
                    for seed in range(seeds)
                ]
                worn[n] = np.array(runs)
            ratio = worn[steps] / worn[100.0] - 1.0
            mean = 100.0 * (worn[steps].sum(axis=0) / worn[100.0].sum(axis=0) - 1.0)
            error = 100.0 * ratio.std(axis=0, ddof=1) / seeds**0.5
            print(f"  e {e:4.2f}, {steps:4.1f} steps, plate {angle:2.0f} deg: "
                  f"{100 * first['total']:+7.1f} / {100 * first['friction']:+6.1f}   "
                  f"{mean[0]:+7.1f} +- {error[0]:.1f} / {mean[2]:+6.1f} +- {error[2]:.1f}",
                  flush=True)  # fmt: skip


def run_unjudged(case: Case, setup: Setup) -> np.ndarray:
    """Return the wear at the end of a run, J, also of a step that would be refused."""
    from abradem.dem import simulation

    limit = simulation.LARGEST_STEP_BIAS
    simulation.LARGEST_STEP_BIAS = float("inf")
    try:
        return run_jet(case, setup).worn[-1]
    finally:
        simulation.LARGEST_STEP_BIAS = limit


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--jets", action="store_true", help="jets beside their first impact only")
    parser.add_argument("--config", type=Path, default=ROOT / "config.yaml")
    asked = parser.parse_args()
    if asked.jets:
        print_jets()
        return
    print_biases(ContactModel())
    print_refused(asked.config)


if __name__ == "__main__":
    main()

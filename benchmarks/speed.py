"""Cost of the two steppings on jets from dilute to crowded: python benchmarks/speed.py [A M B D].

One line a scenario: seconds by islands, seconds by conventional stepping, their ratio. Both give
the same bits, which is checked. Whole `simulate` calls after a warm-up, one process.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from abradem import Case, Setup, simulate
from abradem.dem.warm import warm

WIDE = {
    "plate_length": 0.5,
    "plate_width": 0.5,
    "patch_length": 0.2,
    "patch_width": 0.2,
    "fall_height": 0.5,
    "mass_rate": None,
    "number_rate": 500.0,
    "duration": 2.0,
}


def stone(radius: float, plate_angle: float) -> Case:
    """Limestone-like stones on steel, thrown down at 3 m/s."""
    return Case(
        particle_shear_modulus=6e9,
        particle_poisson_ratio=0.25,
        particle_density=2500.0,
        equipment_shear_modulus=200e9 / 2.6,
        equipment_poisson_ratio=0.3,
        equipment_density=7800.0,
        restitution=0.5,
        rolling_friction=0.05,
        static_friction=0.45,
        archard_constant=1e-9,
        plate_angle=plate_angle,
        factory_angle=0.0,
        particle_radius=radius,
        particle_velocity_y=-3.0,
        seed=1,
    )


SCENARIOS = {
    "A": (stone(0.01, 45.0), WIDE, "dilute jet, 45 degrees, 500 stones a second"),
    "M": (stone(0.01, 20.0), WIDE, "the same, 20 degrees"),
    "B": (stone(0.01, 0.0), WIDE, "the same, level: stones stay on the plate"),
    "D": (stone(0.005, 0.0), {"duration": 1.0}, "5 mm stones, level, 4 kg/s: a bed, 1 s of it"),
}


def timed(case: Case, setup: Setup):
    """Return the seconds of one `simulate` call and its result."""
    start = time.perf_counter()
    result = simulate(case, setup)
    return time.perf_counter() - start, result


def main(names: list[str]) -> None:
    """Print a line for each scenario."""
    warm()
    for name in names or SCENARIOS:
        case, values, meaning = SCENARIOS[name]
        fast, one = timed(case, Setup(**values))
        slow, other = timed(case, Setup(**values, stepping="synchronous"))
        assert np.array_equal(one.worn, other.worn), "the steppings differ"
        print(f"{name}  {fast:8.3f} s  {slow:8.3f} s  {slow / fast:6.1f}   {meaning}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])

"""The command line: predict or simulate wear rates, check a configuration or the results.

Invalid input ends with one line for each problem on stderr and exit code 2, too little memory with
one line and exit code 3. What needs numpy is imported when the command is known, as the import
fails without memory.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Sequence
from pathlib import Path

import abradem
from abradem.cli.arguments import InputError, joined
from abradem.store.errors import memory_problem, too_small_limit

DESCRIPTION = "Wear data sets, models and figures from ranges of materials and geometry."
"""Not from a docstring, as Python has none with PYTHONOPTIMIZE=2."""

WRONG_INPUT = 2
"""Exit code for invalid input."""

NO_MEMORY = 3
"""Exit code for too little memory."""

LEAST_MEMORY = {"simulate": 1000, "sweep": 1000, "predict": 160, "config": 500, "doctor": 500}
"""Address space, MB, below which a command cannot load the libraries that it needs."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code."""
    arguments = sys.argv[1:] if arguments is None else list(arguments)
    command = arguments[0] if arguments and arguments[0] in LEAST_MEMORY else "predict"
    if line := too_small_limit(f"abradem {command}", LEAST_MEMORY[command]):
        print(line, file=sys.stderr)
        return NO_MEMORY
    try:
        from abradem.running.environment import force_environment

        # Before help is printed, which has characters that an encoding may lack.
        force_environment()
        options = _parser().parse_args(joined(arguments))
        return options.run(options)
    except Exception as error:
        if line := memory_problem(error):
            print(line, file=sys.stderr)
            return NO_MEMORY
        if not _is_of_the_user(error):
            raise
        print(error, file=sys.stderr)
        return WRONG_INPUT


def _is_of_the_user(error: Exception) -> bool:
    """Whether an error is due to the user's input or the file system, and not a bug."""
    explained = {"InputError", "ConfigError", "TableError", "PredictionError"}
    names = {kind.__name__ for kind in type(error).__mro__}
    return isinstance(error, OSError) or bool(names & explained)


class _Parser(argparse.ArgumentParser):
    def __init__(self, *args, **options):
        super().__init__(*args, **options)
        # -5mm is a value as -5 is, and not an unknown option: no option begins with a digit.
        # argparse has no public way to say so; a test tells if this one is gone.
        self._negative_number_matcher = re.compile(r"-\.?\d")

    def parse_args(self, args=None, namespace=None):
        # argparse takes positional words only where they are not interrupted by options.
        options, rest = self.parse_known_args(args, namespace)
        if not hasattr(options, "values") or any(word.startswith("-") for word in rest):
            if rest:
                self.error(f"unrecognized arguments: {' '.join(rest)}")
        else:
            options.values = [*options.values, *rest]
        return options

    def error(self, message: str):
        # One line without the usage, which --help prints.
        self.exit(WRONG_INPUT, f"{self.prog}: {message} (see {self.prog} --help)\n")


def _parser() -> argparse.ArgumentParser:
    from abradem.cli.doctor import add_doctor
    from abradem.cli.predict import add_parser as add_predict
    from abradem.cli.simulate import add_simulate
    from abradem.cli.sweep_cases import add_sweep

    parser = _Parser(prog="abradem", description=DESCRIPTION)
    parser.add_argument("--version", action="version", version=f"abradem {abradem.__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="command")

    add_simulate(commands)
    add_sweep(commands)
    add_predict(commands)

    config = commands.add_parser(
        "config",
        help="check a configuration and print what it would run",
        description="Check a configuration and print what it would run.",
    )
    what = config.add_mutually_exclusive_group(required=True)
    what.add_argument(
        "--check",
        nargs="+",
        type=Path,
        metavar="FILE",
        help="files; later files override earlier ones: config.yaml studies/smoke.yaml",
    )
    what.add_argument(
        "--folder",
        nargs="+",
        type=Path,
        metavar="FILE",
        help="check the files and print the folder of the results instead",
    )
    config.set_defaults(run=_check_config)

    add_doctor(commands)
    return parser


def _check_config(options: argparse.Namespace) -> int:
    from abradem.cli.case_input import check_mesh
    from abradem.config import read_config, setup_dict
    from abradem.running.effort import estimate

    files = options.check or options.folder
    config = read_config(*files)
    check_mesh(setup_dict(config))
    if config.calibration.table is not None:
        from abradem.running.given_tables import calibration_inputs

        calibration_inputs(config, files)
    elif config.dataset.external is not None:
        from abradem.running.given_tables import external_input

        found = external_input(config)
        if found.nothing_varies:
            raise InputError(found.nothing_varies)
        if found.repeated:
            print(f"{config.dataset.external}: {found.repeated}", file=sys.stderr)
    print(estimate(config) if options.check else f"results/{config.study}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

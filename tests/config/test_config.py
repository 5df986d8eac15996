# ruff: noqa: E501  (each expected line is the one that the user sees)
"""The configuration: files in the repository, every kind of error, conversion of values."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import re
from pathlib import Path
from typing import get_args

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from abradem.config import (
    Config,
    ConfigError,
    contacts_of,
    documentation,
    explaining,
    jet_is_known,
    load_config,
    read_config,
    reference,
    sampled_ranges,
    schema,
    setup_dict,
    simulation_keys,
    to_yaml,
)
from abradem.dem import model
from abradem.dem.model import Setup
from abradem.quantities import SAMPLED
from abradem.running import effort
from abradem.running.effort import estimate
from abradem.sampling.cost import COSTS, batch_seconds
from abradem.sampling.draw import block_cases

ROOT = Path(__file__).parents[2]
CONFIG = ROOT / "config.yaml"
STUDIES = sorted((ROOT / "studies").glob("*.yaml"))

MALFORMED = {
    "fewest_layers_above_most": (
        "study: a\nlearning:\n  ga_ann:\n    min_layers: 7\n",
        "config.yaml: learning.ga_ann.min_layers: 7: must not exceed max_layers (allowed up to 6)",
    ),
    "elites_fill_the_population": (
        "study: a\nlearning:\n  ga_ann:\n    elites: 10\n",
        "config.yaml: learning.ga_ann.elites: 10: is too many for a population of 10 (allowed up to 9)",
    ),
    "columns_without_a_table": (
        "study: a\ndataset:\n  columns: {plate_angle: slope}\n",
        'config.yaml: dataset.columns: {plate_angle: "slope"}: requires a table in dataset.external',
    ),
    "jet_of_no_table": (
        "study: a\ndataset:\n  jet: stated\n",
        'config.yaml: dataset.jet: "stated": requires a table in dataset.external',
    ),
    "rate_of_no_table": (
        "study: a\ndataset:\n  rate: stated\n",
        'config.yaml: dataset.rate: "stated": requires a table in dataset.external',
    ),
    "jet_in_another_word": (
        "study: a\ndataset:\n  external: t.csv\n  jet: known\n",
        'config.yaml: dataset.jet: "known": is unknown (allowed stated, unknown)',
    ),
    "column_that_is_no_name": (
        "study: a\ndataset:\n  external: t.csv\n  columns: {plate_angle: 3}\n",
        "config.yaml: dataset.columns: {plate_angle: 3}: plate_angle: must be a column name, or [column, unit] (allowed {name: column} or {name: [column, unit]})",
    ),
    "column_that_is_a_list_of_one": (
        "study: a\ndataset:\n  external: t.csv\n  columns: {plate_angle: [x]}\n",
        'config.yaml: dataset.columns: {plate_angle: ["x"]}: plate_angle: must be a column name, or [column, unit] (allowed {name: column} or {name: [column, unit]})',
    ),
    "column_that_is_an_empty_list": (
        "study: a\ncalibration:\n  columns: {plate_angle: []}\n",
        "config.yaml: calibration.columns: {plate_angle: []}: plate_angle: must be a column name, or [column, unit] (allowed {name: column} or {name: [column, unit]})",
    ),
    "column_with_three_parts": (
        "study: a\ndataset:\n  external: t.csv\n  columns: {plate_angle: [x, deg, y]}\n",
        'config.yaml: dataset.columns: {plate_angle: ["x", "deg", "y"]}: plate_angle: must be a column name, or [column, unit] (allowed {name: column} or {name: [column, unit]})',
    ),
    "misspelled_material": (
        "study: a\nsampling:\n  ranges: {particle_density: granit}\n",
        'config.yaml: sampling.ranges.particle_density: "granit": must be a number; did you mean granite? (allowed 10 ... 25000 kg/m3)',
    ),
    "misspelled_material_in_a_pair": (
        "study: a\nsampling:\n  ranges: {particle_density: [1000, Iron ores]}\n",
        'config.yaml: sampling.ranges.particle_density: [1000, "Iron ores"]: must be a number; did you mean iron_ore? (allowed 10 ... 25000 kg/m3)',
    ),
    "misspelled_material_without_the_quantity": (
        "study: a\nsampling:\n  ranges: {particle_density: stel}\n",
        'config.yaml: sampling.ranges.particle_density: "stel": must be a number (allowed 10 ... 25000 kg/m3)',
    ),
    "diameter": (
        "study: a\nsampling:\n  ranges: {particle_diameter: 20}\n",
        "config.yaml: sampling.ranges.particle_diameter: 20: unknown key, give half of the diameter as particle_radius_mm",
    ),
    "diameter_mm": (
        "study: a\nfigures:\n  typical: {particle_diameter_mm: 20}\n",
        "config.yaml: figures.typical.particle_diameter_mm: 20: unknown key, give half of the diameter as particle_radius_mm",
    ),
    "diameter_alone": (
        "study: a\nsampling:\n  ranges: {Diameter_mm: [20, 30]}\n",
        "config.yaml: sampling.ranges.Diameter_mm: [20, 30]: unknown key, give half of the diameter as particle_radius_mm",
    ),
    "diameter_elsewhere": (
        "study: a\nsimulation: {particle_diameter_mm: 20}\n",
        "config.yaml: simulation.particle_diameter_mm: 20: unknown key, give half of the diameter as sampling.ranges.particle_radius_mm",
    ),
    "diameter_of_the_arc": (
        "study: a\nsimulation: {factory: {arc_diameter_mm: 20}}\n",
        "config.yaml: simulation.factory.arc_diameter_mm: 20: unknown key, give half of the diameter as arc_radius_mm",
    ),
    "columns_that_are_a_list": (
        "study: a\ndataset:\n  external: t.csv\n  columns: [slope]\n",
        'config.yaml: dataset.columns: ["slope"]: must map names of quantities to columns of the table (allowed {name: column} or {name: [column, unit]})',
    ),
    "external_that_is_no_path": (
        "study: a\ndataset:\n  external: 3\n",
        "config.yaml: dataset.external: 3: must be text; put it in quotes (allowed the path of a file or null)",
    ),
    "misspelled_section": (
        "study: a\nsimulatoin:\n  gravity: 9.81\n",
        "config.yaml: simulatoin: {gravity: 9.81}: unknown key, did you mean simulation?",
    ),
    "misspelled_key": (
        "study: a\nsampling:\n  blokcs: 3\n",
        "config.yaml: sampling.blokcs: 3: unknown key, did you mean blocks?",
    ),
    "key_of_another_section": (
        "study: a\nsampling:\n  window_s: 3\n",
        "config.yaml: sampling.window_s: 3: unknown key here, did you mean simulation.stop.window_s?",
    ),
    "unknown_key_like_no_other": (
        "study: a\nfigures:\n  zebra: 3\n",
        "config.yaml: figures.zebra: 3: unknown key (allowed formats, series_cases, typical, angles, movie)",
    ),
    "duplicate_key": (
        "study: a\nsampling:\n  blocks: 2\n  method: lhs\n  blocks: 3\n",
        "config.yaml: sampling.blocks: 3: given twice, on lines 3 and 5; a key may be given only once",
    ),
    "duplicate_section": (
        "study: a\nsampling:\n  blocks: 2\nsampling:\n  method: lhs\n",
        'config.yaml: sampling: {method: "lhs"}: given twice, on lines 2 and 4; a key may be given only once',
    ),
    "whole_number_in_quotes": (
        'study: a\nseed: "7"\n',
        'config.yaml: seed: "7": must be a whole number, not text; write it without quotes (allowed 0 ... 9223372036854775807)',
    ),
    "number_in_quotes": (
        'study: a\nsimulation:\n  gravity: "9.81"\n',
        'config.yaml: simulation.gravity: "9.81": must be a number, not text; write it without quotes (allowed 0 ... 1000 m/s2)',
    ),
    "exponent_without_point": (
        "study: a\nsampling:\n  ranges:\n    archard_constant: [1e-10, 1.0e-8]\n",
        'config.yaml: sampling.ranges.archard_constant: ["1e-10", 1.0e-08]: must be a number; YAML reads this as text, write 1.0e-10 (allowed 1.0e-16 ... 0.0001 1/Pa)',
    ),
    "true_for_a_number": (
        "study: a\nsimulation:\n  gravity: true\n",
        "config.yaml: simulation.gravity: true: must be a number (allowed 0 ... 1000 m/s2)",
    ),
    "true_for_a_bound": (
        "study: a\nsampling:\n  ranges:\n    restitution: [false, true]\n",
        "config.yaml: sampling.ranges.restitution: [false, true]: must be a number (allowed 0.05 ... 1)",
    ),
    "nan": (
        "study: a\nsimulation:\n  gravity: .nan\n",
        "config.yaml: simulation.gravity: .nan: must be a finite number (allowed 0 ... 1000 m/s2)",
    ),
    "infinity": (
        "study: a\nsimulation:\n  stop:\n    max_time_s: .inf\n",
        "config.yaml: simulation.stop.max_time_s: .inf: must be a finite number (allowed above 0 up to 100000 s)",
    ),
    "nan_for_a_bound": (
        "study: a\nsampling:\n  ranges:\n    plate_angle: [0, .nan]\n",
        "config.yaml: sampling.ranges.plate_angle: [0, .nan]: must be a finite number (allowed -90 ... 90 deg)",
    ),
    "swapped_bounds": (
        "study: a\nsampling:\n  ranges:\n    restitution: [0.9, 0.2]\n",
        "config.yaml: sampling.ranges.restitution: [0.9, 0.2]: lower bound must not exceed the upper bound (allowed 0.05 ... 1)",
    ),
    "bound_out_of_physical_limits": (
        "study: a\nsampling:\n  ranges:\n    particle_poisson_ratio: [0.2, 0.6]\n",
        "config.yaml: sampling.ranges.particle_poisson_ratio: [0.2, 0.6]: 0.6 is out of range (allowed 0 ... 0.499)",
    ),
    "fixed_value_out_of_limits": (
        "study: a\nsampling:\n  ranges:\n    restitution: 0\n",
        "config.yaml: sampling.ranges.restitution: 0: 0 is out of range (allowed 0.05 ... 1)",
    ),
    "upward_velocity": (
        "study: a\nsampling:\n  ranges:\n    particle_velocity_y: [-10, 5]\n",
        "config.yaml: sampling.ranges.particle_velocity_y: [-10, 5]: 5 is out of range (allowed -30 ... 0 m/s)",
    ),
    "shear_modulus_in_pascal": (
        "study: a\nsampling:\n  ranges:\n    particle_shear_modulus_gpa: [2.0e+9, 1.0e+10]\n",
        "config.yaml: sampling.ranges.particle_shear_modulus_gpa: [2000000000.0, 10000000000.0]: 2.0e+09 is out of range; the key is in GPa, for values in Pa write [2, 10] (allowed 0.001 ... 1000 GPa)",
    ),
    "radius_in_metres": (
        "study: a\nsampling:\n  ranges:\n    particle_radius_mm: [0.005, 0.04]\n",
        "config.yaml: sampling.ranges.particle_radius_mm: [0.005, 0.04]: 0.005 is out of range; the key is in mm, for values in m write [5, 40] (allowed 0.1 ... 100 mm)",
    ),
    "unit_missing_in_the_key": (
        "study: a\nsampling:\n  ranges:\n    particle_shear_modulus: [2, 10]\n",
        "config.yaml: sampling.ranges.particle_shear_modulus: [2, 10]: unknown key, did you mean particle_shear_modulus_gpa (in GPa)?",
    ),
    "second_missing_in_the_key": (
        "study: a\nsimulation:\n  stop:\n    window: 5\n",
        "config.yaml: simulation.stop.window: 5: unknown key, did you mean window_s (in s)?",
    ),
    "wrong_unit_in_the_key": (
        "study: a\nsampling:\n  ranges:\n    particle_radius_m: [0.005, 0.04]\n",
        "config.yaml: sampling.ranges.particle_radius_m: [0.005, 0.04]: unknown key, did you mean particle_radius_mm (in mm)?",
    ),
    "three_bounds": (
        "study: a\nsampling:\n  ranges:\n    restitution: [0.2, 0.5, 0.8]\n",
        "config.yaml: sampling.ranges.restitution: [0.2, 0.5, 0.8]: must be one number or two, [lower bound, upper bound] (allowed 0.05 ... 1)",
    ),
    "range_as_text": (
        "study: a\nsampling:\n  ranges:\n    restitution: 0.2-0.8\n",
        'config.yaml: sampling.ranges.restitution: "0.2-0.8": must be a number (allowed 0.05 ... 1)',
    ),
    "unknown_method": (
        "study: a\nsampling:\n  method: latin\n",
        'config.yaml: sampling.method: "latin": is unknown (allowed lhs, sobol, uniform)',
    ),
    "no_cases": (
        "study: a\nsampling:\n  cases_per_block: 0\n",
        "config.yaml: sampling.cases_per_block: 0: is out of range (allowed 1 ... 100000)",
    ),
    "negative_number_of_blocks": (
        "study: a\nsampling:\n  blocks: -1\n",
        "config.yaml: sampling.blocks: -1: is out of range (allowed 1 ... 10000)",
    ),
    "too_many_cases": (
        "study: a\nsampling:\n  cases_per_block: 1000000000\n",
        "config.yaml: sampling.cases_per_block: 1000000000: is out of range (allowed 1 ... 100000)",
    ),
    "half_a_case": (
        "study: a\nsampling:\n  cases_per_block: 12.5\n",
        "config.yaml: sampling.cases_per_block: 12.5: must be a whole number (allowed 1 ... 100000)",
    ),
    "empty_file": (
        "",
        "config.yaml: the file is empty; it must contain keys, such as study",
    ),
    "nothing_but_comments": (
        "# nothing\n",
        "config.yaml: the file is empty; it must contain keys, such as study",
    ),
    "list_instead_of_keys": (
        "- study\n",
        'config.yaml: contains ["study"], not keys; it must begin with a key, such as study',
    ),
    "word_instead_of_keys": (
        "paper\n",
        'config.yaml: contains "paper", not keys; it must begin with a key, such as study',
    ),
    "not_utf8": (
        b"study: a # \xe9\n",
        "config.yaml: byte 12 is not UTF-8; save the file as UTF-8 text",
    ),
    "tag_that_would_run_code": (
        "study: !!python/object/apply:os.system ['true']\n",
        "config.yaml: line 1: the tag !!python/object/apply:os.system is refused; only plain numbers, text, lists and keys are read",
    ),
    "broken_yaml": (
        "study: [a\n",
        "config.yaml: line 2: not valid YAML: expected ',' or ']', but got '<stream end>'",
    ),
    "tab_as_indent": (
        "study: a\nsampling:\n\tblocks: 2\n",
        "config.yaml: line 3: not valid YAML: found character '\\t' that cannot start any token",
    ),
    "study_leaves_the_results_folder": (
        "study: ../../etc\n",
        'config.yaml: study: "../../etc": has the wrong form (allowed letters, digits, _ and -, beginning with a letter or digit, at most 64)',
    ),
    "study_with_odd_characters": (
        "study: my study!\n",
        'config.yaml: study: "my study!": has the wrong form (allowed letters, digits, _ and -, beginning with a letter or digit, at most 64)',
    ),
    "hidden_study": (
        "study: .hidden\n",
        'config.yaml: study: ".hidden": has the wrong form (allowed letters, digits, _ and -, beginning with a letter or digit, at most 64)',
    ),
    "study_is_a_number": (
        "study: 2024\n",
        "config.yaml: study: 2024: must be text; put it in quotes (allowed letters, digits, _ and -, beginning with a letter or digit, at most 64)",
    ),
    "no_study": (
        "seed: 1\n",
        "config.yaml: study: (missing): is required (allowed letters, digits, _ and -, beginning with a letter or digit, at most 64)",
    ),
    "both_feeds": (
        "study: a\nsimulation:\n  factory:\n    number_rate_per_s: 100\n",
        "config.yaml: simulation.factory.number_rate_per_s: 100: feed: mass takes its rate from mass_rate_kg_s (allowed null here)",
    ),
    "mass_feed_without_mass_rate": (
        "study: a\nsimulation:\n  factory:\n    mass_rate_kg_s: null\n",
        "config.yaml: simulation.factory.mass_rate_kg_s: null: feed: mass needs this rate (allowed a number above 0)",
    ),
    "unknown_feed": (
        "study: a\nsimulation:\n  factory:\n    feed: volume\n",
        'config.yaml: simulation.factory.feed: "volume": is unknown (allowed mass, number)',
    ),
    "negative_mass_rate": (
        "study: a\nsimulation:\n  factory:\n    mass_rate_kg_s: -4\n",
        "config.yaml: simulation.factory.mass_rate_kg_s: -4: is out of range (allowed above 0 up to 1.0e+06 kg/s or null)",
    ),
    "time_step_in_percent": (
        "study: a\nsimulation:\n  time_step_rayleigh_fraction: 20\n",
        "config.yaml: simulation.time_step_rayleigh_fraction: 20: is out of range (allowed 0.001 ... 0.4)",
    ),
    "particle_wider_than_the_plate": (
        "study: a\nsimulation:\n  plate:\n    length_mm: 60\n",
        "config.yaml: sampling.ranges.particle_radius_mm: [5.0, 40.0] (default): a particle must not be wider than the plate (allowed radius up to 30 mm on a plate of 60 x 300 mm)",
    ),
    "facet_larger_than_the_plate": (
        "study: a\nsimulation:\n  plate:\n    facet_size_mm: 400\nwear_rate:\n  element_size_mm: null\n",
        "config.yaml: simulation.plate.facet_size_mm: 400: a facet must not be larger than the plate (allowed up to 300 mm)",
    ),
    "too_many_facets": (
        "study: a\nsimulation:\n  plate:\n    facet_size_mm: 0.01\n",
        "config.yaml: simulation.plate.facet_size_mm: 0.01: divides the plate into 900000000 facets (allowed up to 1000000)",
    ),
    "end_before_the_window_closes": (
        "study: a\nsimulation:\n  stop:\n    max_time_s: 2\n",
        "config.yaml: simulation.stop.max_time_s: 2: must be longer than the window (allowed above 2 s)",
    ),
    "too_few_samples": (
        "study: a\nsimulation:\n  stop:\n    sample_interval_s: 1\n",
        "config.yaml: simulation.stop.sample_interval_s: 1: gives too few samples for 20 batches of the window (allowed up to 0.1 s)",
    ),
    "empty_section": (
        "study: a\nsampling:\n",
        "config.yaml: sampling: null: is an empty section; give keys or remove the line (allowed method, blocks, cases_per_block, ranges)",
    ),
    "number_instead_of_a_section": (
        "study: a\nsampling: 200\n",
        "config.yaml: sampling: 200: must be a section of keys (allowed method, blocks, cases_per_block, ranges)",
    ),
    "unknown_word_for_cases_per_job": (
        "study: a\nsimulation:\n  cases_per_job: many\n",
        'config.yaml: simulation.cases_per_job: "many": must be auto or a whole number (allowed auto or 1 ... 100000)',
    ),
    "no_cases_in_a_job": (
        "study: a\nsimulation:\n  cases_per_job: 0\n",
        "config.yaml: simulation.cases_per_job: 0: is out of range (allowed auto or 1 ... 100000)",
    ),
    "pair_interaction_as_a_word": (
        "study: a\nsimulation:\n  pair_interaction: same\n",
        'config.yaml: simulation.pair_interaction: "same": must be a section of keys (allowed restitution, static_friction, rolling_friction)',
    ),
    "unknown_target": (
        "study: a\nlearning:\n  target: wear_mean\n",
        'config.yaml: learning.target: "wear_mean": is unknown (allowed wear_total_mean, wear_total_worn, wear_total_footprint, wear_total_p99, wear_total_max, wear_sliding_mean, wear_sliding_worn, wear_sliding_footprint, wear_sliding_p99, wear_sliding_max, wear_friction_mean, wear_friction_worn, wear_friction_footprint, wear_friction_p99, wear_friction_max)',
    ),
    "arc_that_reaches_the_plate": (
        "study: a\nsimulation:\n  factory: {arc_radius_mm: 475, angle_acts: arc}\n",
        "config.yaml: simulation.factory.arc_radius_mm: 475: must be less than the fall height (allowed below 475 mm)",
    ),
    "elements_that_do_not_fit": (
        "study: a\nwear_rate:\n  element_size_mm: 40\n",
        "config.yaml: wear_rate.element_size_mm: 40: does not divide 300 mm of the plate into whole facets of 10 mm (allowed 10, 20, 30, 50, 60, 100, 150, 300)",
    ),
    "elements_within_a_facet": (
        "study: a\nwear_rate:\n  element_size_mm: 5\n",
        "config.yaml: wear_rate.element_size_mm: 5: does not divide 300 mm of the plate into whole facets of 10 mm (allowed 10, 20, 30, 50, 60, 100, 150, 300)",
    ),
    "case_that_does_not_exist": (
        "study: a\nfigures:\n  series_cases: [0, 500]\n",
        "config.yaml: figures.series_cases: [0, 500]: there is no case 500 (allowed 0 ... 199)",
    ),
    "negative_case": (
        "study: a\nfigures:\n  series_cases: [-1]\n",
        "config.yaml: figures.series_cases[0]: -1: is out of range (allowed a list of case numbers from 0)",
    ),
    "format_instead_of_a_list": (
        "study: a\nfigures:\n  formats: svg\n",
        'config.yaml: figures.formats: "svg": must be a list (allowed a list of pdf and png)',
    ),
    "unknown_format": (
        "study: a\nfigures:\n  formats: [svg]\n",
        'config.yaml: figures.formats[0]: "svg": is unknown (allowed a list of pdf and png)',
    ),
    "no_format": (
        "study: a\nfigures:\n  formats: []\n",
        "config.yaml: figures.formats: []: must not be empty (allowed a list of pdf and png)",
    ),
    "no_png_for_the_report": (
        "study: a\nfigures:\n  formats: [pdf]\n",
        'config.yaml: figures.formats: ["pdf"]: must include png, which the report shows (allowed pdf, png)',
    ),
    "file_that_refers_to_itself": (
        "study: a\nsampling: &s\n  ranges: *s\n",
        "config.yaml: line 2: nested more than 8 levels deep",
    ),
    "number_as_a_key": (
        "study: a\n1: 2\n",
        "config.yaml: line 2: a key must be a plain word",
    ),
    "impossible_date": (
        "study: 2024-13-45\n",
        'config.yaml: study: 2024-13-45: YAML reads this as a date; write "2024-13-45" in quotes',
    ),
    "two_problems": (
        "study: a b\nseed: -1\n",
        'config.yaml: study: "a b": has the wrong form (allowed letters, digits, _ and -, beginning with a letter or digit, at most 64)\nconfig.yaml: seed: -1: is out of range (allowed 0 ... 9223372036854775807)',
    ),
    "seed_beyond_64_bits": (
        "study: a\nseed: 99999999999999999999\n",
        "config.yaml: seed: 99999999999999999999: is out of range (allowed 0 ... 9223372036854775807)",
    ),
    "no_seed": (
        "study: a\nseed: null\n",
        "config.yaml: seed: null: must be a whole number (allowed 0 ... 9223372036854775807)",
    ),
    "line_break_in_a_key": (
        'study: a\n"se\\ned": 3\n',
        "config.yaml: se\\ned: 3: unknown key, did you mean seed?",
    ),
    "long_value_is_cut": (
        "study: " + "a" * 100 + "\n",
        'config.yaml: study: "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa ...: has the wrong form (allowed letters, digits, _ and -, beginning with a letter or digit, at most 64)',
    ),
    "merge_key": (
        "study: a\n<<: {seed: 3}\n",
        "config.yaml: line 2: a key must be a plain word",
    ),
    "anchors_that_stand_for_millions": (
        "study: a\na: &a [0, 0, 0, 0, 0, 0, 0, 0, 0, 0]\n"
        + "".join(
            f"{to}: &{to} [{', '.join([f'*{of}'] * 10)}]\n"
            for of, to in ("ab", "bc", "cd", "de", "ef")
        ),
        "config.yaml: line 2: holds more than 20000 values",
    ),
    "thousands_of_brackets": (
        "study: " + "[" * 5000,
        "config.yaml: nested more than 8 levels deep",
    ),
    "larger_than_any_configuration": (
        "study: a\n" + "# more\n" * 200_000,
        "config.yaml: is larger than 1000 kB",
    ),
    "template_that_would_run_code": (
        "__use_yte__: true\nstudy: ?open('x', 'w')\n",
        """config.yaml: study: "?open('x', 'w')": has the wrong form (allowed letters, digits, _ and -, beginning with a letter or digit, at most 64)\nconfig.yaml: __use_yte__: true: unknown key (allowed study, seed, sampling, simulation, wear_rate, dataset, features, learning, calibration, figures, publish)""",
    ),
    "more_cases_than_there_is_time_for": (
        "study: a\nsampling:\n  blocks: 10000\n  cases_per_block: 100000\n",
        "config.yaml: sampling.blocks: 10000: makes 1000000000 cases with 100000 in a block (allowed up to 1000000 cases in all)",
    ),
    "more_jobs_than_a_workflow_holds": (
        "study: a\nsampling:\n  blocks: 10\n  cases_per_block: 10000\nsimulation:\n  cases_per_job: 1\n",
        "config.yaml: simulation.cases_per_job: 1: makes 100000 simulation jobs (allowed up to 20000; take more cases per job, or fewer and larger blocks)",
    ),
    "more_samples_than_a_series_holds": (
        "study: a\nsimulation:\n  stop:\n    sample_interval_s: 0.00001\n",
        "config.yaml: simulation.stop.sample_interval_s: 1.0e-05: gives more than 100000 samples in max_time_s (allowed from 8e-05 s)",
    ),
    "maps_that_fill_the_memory": (
        "study: a\nsimulation:\n  plate:\n    facet_size_mm: 0.5\n  stop:\n    max_time_s: 25000\n    window_s: 5\n    sample_interval_s: 0.25\n",
        "config.yaml: simulation.plate.facet_size_mm: 0.5: with 360000 facets, 50000 maps of a case would fill the memory; take larger facets, a longer window or a shorter max_time_s (allowed 4 GB)",
    ),
    "step_that_never_ends": (
        "study: a\nsimulation:\n  time_step_rayleigh_fraction: 1.0e-9\n",
        "config.yaml: simulation.time_step_rayleigh_fraction: 1.0e-09: is out of range (allowed 0.001 ... 0.4)",
    ),
    "name_taken_by_the_benchmarks": (
        "study: Benchmarks\n",
        'config.yaml: study: "Benchmarks": is taken by the results of make bench (allowed: another name)',
    ),
    "table_that_the_study_itself_writes": (
        "study: a\ndataset:\n  external: results/a/dataset.parquet\n",
        'config.yaml: dataset.external: "results/a/dataset.parquet": is a result of this study itself (allowed: a file elsewhere, or another study)',
    ),
    "number_beyond_double_precision": (
        "study: a\nsimulation:\n  gravity: 1" + "0" * 400 + "\n",
        "config.yaml: simulation.gravity: 10000000000000000000000000000000000000000000000000000000 ...: must be a number (allowed 0 ... 1000 m/s2)",
    ),
}


@pytest.fixture
def write(tmp_path, monkeypatch):
    """Work in an empty folder; the fixture writes a file there and returns its name."""
    monkeypatch.chdir(tmp_path)

    def write(text: str | bytes, name: str = "config.yaml") -> str:
        Path(name).write_bytes(text if isinstance(text, bytes) else text.encode())
        return name

    return write


@pytest.mark.parametrize("name", MALFORMED)
def test_each_mistake_prints_its_line(write, name):
    text, line = MALFORMED[name]
    with pytest.raises(ConfigError) as error:
        read_config(write(text))
    assert str(error.value) == line


def test_the_list_of_mistakes_is_long_and_each_problem_is_one_line():
    assert len(MALFORMED) >= 30
    for text, lines in MALFORMED.values():
        assert all(line.startswith("config.yaml: ") for line in lines.split("\n")), text


HINTED = [
    ("publish.version", "1.10"), ("publish.version", "01"), ("publish.version", "0x10"),
    ("publish.version", ".5"), ("publish.version", "2026-01-31"), ("publish.version", "2"),
    ("publish.version", "1.5"), ("publish.version", "no"), ("study", ".5"), ("study", "010"),
    ("study", "1.10"), ("study", "0x10"), ("study", "12:30"), ("study", "2024"), ("study", "1.5"),
    ("study", "+5"), ("study", "2026-02-30"), ("study", "no"), ("publish.date", "2026-02-30"),
    ("publish.date", "2026-01-31"), ("publish.date", "2026-13-01"), ("publish.date", "20260131"),
    ("publish.date", "2026-01-31 10:00:00"), ("publish.date", "1_0"), ("publish.url", "010"),
    ("publish.url", "yes"), ("publish.title", "010"), ("publish.title", "2026-02-30"),
    ("sampling.method", "no"), ("sampling.method", "010"), ("sampling.blocks", "00"),
    ("sampling.blocks", "-010"), ("sampling.blocks", "1:30"), ("sampling.blocks", "0x10"),
    ("seed", "-0x10"), ("learning.test_share", "1_0"), ("learning.test_share", "1:30"),
    ("sampling.ranges.plate_angle", "1:30:30"), ("sampling.ranges.plate_angle", "010"),
    ("figures.typical.plate_angle", "0x7f"), ("simulation.cases_per_job", "00"),
]  # fmt: skip


@pytest.mark.parametrize(("key", "text"), HINTED)
def test_a_hint_is_accepted_when_it_is_followed(write, key, text):
    """Where there is nothing to propose, the line says what is allowed."""

    def problem(given):
        *sections, name = key.split(".")
        content = "{" + f"{name}: {given}" + "}"
        for section in reversed(sections):
            content = "{" + f"{section}: {content}" + "}"
        study = content if key == "study" else "{study: a, " + content[1:]
        try:
            read_config(write(study))
        except ConfigError as error:
            (line,) = error.problems
            return line
        return None

    line = problem(text)
    assert line is not None
    if "put it in quotes" in line:
        assert problem(f'"{text}"') is None
    elif found := re.search(r"; write (\S+?)(?: in quotes|, or (\S+) if| if|$)", line):
        for proposed in filter(None, found.groups()):
            assert problem(proposed) is None
    else:
        assert "(allowed " in line and "quotes" not in line.split("(allowed")[0]


@pytest.mark.parametrize(
    ("key", "text", "problem"),
    [
        (
            "publish: {version: 1.10}",
            "1.10",
            "YAML reads this as the number 1.1 (allowed 1.0.0, 1.0.1, 2.0.0 ...)",
        ),
        (
            "publish: {date: 2026-02-30}",
            "2026-02-30",
            'there is no such day (allowed null or a date in quotes, "2026-01-31")',
        ),
    ],
)
def test_without_a_hint_what_is_allowed_is_said(write, key, text, problem):
    with pytest.raises(ConfigError) as error:
        read_config(write(f"study: a\n{key}\n"))
    assert error.value.problems[0].endswith(f": {text}: {problem}")


def test_what_is_no_file_is_one_line(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe.yaml")
    Path("folder.yaml").mkdir()
    Path("link.yaml").symlink_to("pipe.yaml")
    expected = {
        "pipe.yaml": "pipe.yaml: is a pipe or a device, not a file",
        "folder.yaml": "folder.yaml: is a folder, not a file",
        "link.yaml": "pipe.yaml: is a pipe or a device, not a file",
        "/dev/null": "/dev/null: is a pipe or a device, not a file",
    }
    for name, line in expected.items():
        with pytest.raises(ConfigError) as error:
            read_config(name)
        assert error.value.problems == [line]


RATE = "simulation.factory.mass_rate_kg_s"
LENGTH, WIDTH = "simulation.factory.patch_length_mm", "simulation.factory.patch_width_mm"


@pytest.mark.parametrize(
    ("name", "given", "read"),
    [
        (RATE, {"from": "14.4 t/h", "to": 80}, {"from": 4.0, "to": 80}),
        (
            RATE,
            {"from": 1, "to": "36 t/h", "scale": "log"},
            {"from": 1, "to": 10.0, "scale": "log"},
        ),
        (RATE, ["14.4 t/h", 5], [4.0, 5]),
        (f"{LENGTH}, {WIDTH}", ["10 cm", "0.2 m"], [100.0, 200.0]),
        (RATE, [1, 2], [1, 2]),
        (
            "simulation.contact.tangential",
            ["incremental", "displacement"],
            ["incremental", "displacement"],
        ),
        ("simulation.none.such", ["1 m", 2], ["1 m", 2]),
    ],
)
def test_values_of_a_search_may_have_a_unit(name, given, read):
    config = load_config({"study": "a", "calibration": {"search": {name: given}}})
    found = config.calibration.search[name]
    assert found == (pytest.approx(read) if all(map(is_number, read)) else read)


def is_number(value):
    return isinstance(value, (int, float))


@pytest.mark.parametrize(
    ("name", "given"),
    [(RATE, ["4 m", 5]), (RATE, {"from": "4 zebras", "to": 5}), (f"{LENGTH}, {RATE}", ["1 m", 2])],
)
def test_a_wrong_unit_of_a_search_is_one_line(name, given):
    with pytest.raises(ConfigError) as error:
        load_config({"study": "a", "calibration": {"search": {name: given}}})
    (line,) = error.value.problems
    assert line.startswith("command line: calibration.search: ") and f": {name}: " in line


def test_missing_file_is_one_line(write):
    with pytest.raises(ConfigError, match=r"^studies/none\.yaml: there is no such file$"):
        read_config("studies/none.yaml")


def test_problem_names_the_file_in_which_the_value_stands(write):
    base = write("study: a\nsampling:\n  blocks: 0\n")
    overlay = write("sampling:\n  cases_per_block: 0\n", "overlay.yaml")
    with pytest.raises(ConfigError) as error:
        read_config(base, overlay)
    assert error.value.problems == [
        "config.yaml: sampling.blocks: 0: is out of range (allowed 1 ... 10000)",
        "overlay.yaml: sampling.cases_per_block: 0: is out of range (allowed 1 ... 100000)",
    ]


def test_all_unreadable_files_are_named(write):
    with pytest.raises(ConfigError) as error:
        read_config(write("", "one.yaml"), write("a: [", "two.yaml"))
    assert [line.split(":")[0] for line in error.value.problems] == ["one.yaml", "two.yaml"]


@pytest.mark.parametrize(
    ("entry", "line"),
    [
        ("sampling={blocks: many}",
         'command line: sampling.blocks: "many": must be a whole number (allowed 1 ... 10000)'),
        ("sampling={blocks: 0}",
         "command line: sampling.blocks: 0: is out of range (allowed 1 ... 10000)"),
        ("blocks=3",
         "command line: blocks: 3: unknown key here, did you mean sampling.blocks?"),
        ("study=../up",
         'command line: study: "../up": has the wrong form (allowed letters, digits, _ and -, '
         "beginning with a letter or digit, at most 64)"),
        ("sampling={blocks: 3",
         'command line: sampling: "{blocks: 3": not valid YAML: expected \',\' or \'}\', but got '
         "'<stream end>'"),
        ("study=!!python/name:os.system ''",
         'command line: study: "!!python/name:os.system \'\'": the tag !!python/name:os.system is '
         "refused; only plain numbers, text, lists and keys are read"),
    ],
)  # fmt: skip
def test_problem_of_the_command_line_is_named_so(write, entry, line):
    name = write("study: a\nsampling:\n  blocks: 2\n")
    with pytest.raises(ConfigError) as error:
        read_config(name, command_line=[entry])
    assert str(error.value) == line


def test_values_of_the_command_line_override_those_of_the_files(write):
    name = write("study: a\nsampling:\n  blocks: 2\n  method: sobol\n")
    config = read_config(
        name,
        command_line=[
            "sampling={blocks: 3, ranges: {restitution: [0.3, 0.5]}}",
            "simulation='{pair_interaction: null}'",
            'study="2024"',
            "publish={title: 'no', creators: [\"010\"]}",
        ],
    )
    assert (config.study, config.sampling.blocks, config.sampling.method) == ("2024", 3, "sobol")
    assert config.sampling.ranges.restitution == (0.3, 0.5)
    assert config.simulation.pair_interaction is None
    assert (config.publish.title, config.publish.creators) == ("no", ["010"])


NUMBER, WHOLE, TEXT = "simulation.gravity", "sampling.blocks", "publish.title"
MISREAD = [
    (WHOLE, "010", "YAML reads this as the number 8; write 10, or 8 if that is meant", 10),
    (WHOLE, "0x10", "YAML reads this as the number 16; write 16", 16),
    (WHOLE, "0b101", "YAML reads this as the number 5; write 5", 5),
    (WHOLE, "1_000", "YAML reads this as the number 1000; write 1000", 1000),
    (WHOLE, "1:30", "YAML reads this as the number 90; write 90 if that is meant", 90),
    (WHOLE, "0o10", "must be a whole number; YAML reads this as text, write 8", 8),
    (WHOLE, "1e1", "must be a whole number; YAML reads this as text, write 10", 10),
    (WHOLE, "1.0e+1", "must be a whole number; write 10", 10),
    (WHOLE, "10.0", "must be a whole number; write 10", 10),
    (WHOLE, '"010"', "must be a whole number; YAML reads this as text, write 10", 10),
    (WHOLE, '"1_000"', "must be a whole number; YAML reads this as text, write 1000", 1000),
    (WHOLE, "yes", "YAML reads this as true; write a whole number", None),
    (WHOLE, "1e9", "must be a whole number in the allowed range", None),
    (NUMBER, "010", "YAML reads this as the number 8; write 10, or 8 if that is meant", 10.0),
    (NUMBER, "1_0.5", "YAML reads this as the number 10.5; write 10.5", 10.5),
    (NUMBER, "1:30.5", "YAML reads this as the number 90.5; write 90.5 if that is meant", 90.5),
    (NUMBER, "off", "YAML reads this as false; write a number", None),
    (NUMBER, "2026-11-27", "YAML reads this as a date; write a number", None),
    (NUMBER, "1e1", "must be a number; YAML reads this as text, write 10.0", 10.0),
    (NUMBER, ".5e2", "must be a number; YAML reads this as text, write 50.0", 50.0),
    (NUMBER, "5e-7", "must be a number; YAML reads this as text, write 5.0e-07", 5e-7),
    (NUMBER, '"9,81"', "must be a number, with a decimal point instead of a comma", None),
    (TEXT, "010", 'YAML reads this as the number 8; write "010" in quotes', "010"),
    (TEXT, "1.10", 'YAML reads this as the number 1.1; write "1.10" in quotes', "1.10"),
    (TEXT, "12:30:45", 'YAML reads this as the number 45045; write "12:30:45" in quotes',
     "12:30:45"),
    (TEXT, "No", 'YAML reads this as false; write "No" in quotes', "No"),
    (TEXT, "on", 'YAML reads this as true; write "on" in quotes', "on"),
    (TEXT, "2026-11-27", 'YAML reads this as a date; write "2026-11-27" in quotes', "2026-11-27"),
    (TEXT, "2026-02-30", 'YAML reads this as a date; write "2026-02-30" in quotes', "2026-02-30"),
]  # fmt: skip


def nested(key, text):
    *sections, name = key.split(".")
    text = f"{name}: {text}"
    for section in reversed(sections):
        text = f"{section}: {{{text}}}"
    return text


def value_at(config, key):
    for name in key.split("."):
        config = getattr(config, name)
    return config


@pytest.mark.parametrize(("key", "word", "problem", "meant"), MISREAD)
def test_a_word_that_yaml_reads_as_another_value_is_refused_as_it_is_written(
    write, key, word, problem, meant
):
    """In a file and on the command line; what the line says to write is accepted."""
    text = nested(key, word)
    section, _, rest = text.partition(": ")
    for origin, run in (
        ("config.yaml", lambda: read_config(write(f"study: a\n{text}\n"))),
        (
            "command line",
            lambda: read_config(write("study: a\n"), command_line=[f"{section}={rest}"]),
        ),
    ):
        with pytest.raises(ConfigError) as error:
            run()
        (line,) = error.value.problems
        assert line.startswith(f"{origin}: {key}: ") and f": {problem}" in line
        if "YAML reads this as the" in problem or "as a date" in problem:
            assert line.startswith(f"{origin}: {key}: {word}: ")
    hints = re.findall(r"write (\S+)", problem.removesuffix("write a whole number"))
    if meant is not None:
        assert value_at(read_config(write(f"study: a\n{nested(key, hints[0])}\n")), key) == meant


def test_a_number_within_lists_ranges_and_unknown_sections_is_looked_at_as_well(write):
    with pytest.raises(ConfigError) as error:
        read_config(
            write(
                "study: 0x10\nsampling:\n  ranges: {plate_angle: [010, 1:30]}\nblocks: 010\n"
                "learning: {surrogate: {hidden: [0o17, 1_0]}}\nfigures: {series_cases: [00]}\n"
                "dataset: {external: t.csv, columns: {plate_angle: [1:30, on]}}\n"
                "publish: {creators: [1.50], series: yes}\n"
            )
        )
    assert sorted(error.value.problems) == sorted([
        'config.yaml: study: 0x10: YAML reads this as the number 16; write "0x10" in quotes',
        "config.yaml: sampling.ranges.plate_angle[0]: 010: YAML reads this as the number 8; write 10, or 8 if that is meant",
        "config.yaml: sampling.ranges.plate_angle[1]: 1:30: YAML reads this as the number 90; write 90 if that is meant",
        'config.yaml: blocks: "010": unknown key here, did you mean sampling.blocks?',
        'config.yaml: learning.surrogate.hidden[0]: "0o17": must be a whole number; YAML reads this as text, write 15 (allowed a list of numbers from 1 to 10000)',
        "config.yaml: learning.surrogate.hidden[1]: 1_0: YAML reads this as the number 10; write 10",
        "config.yaml: figures.series_cases[0]: 00: YAML reads this as the number 0; write 0",
        'config.yaml: dataset.columns.plate_angle[0]: 1:30: YAML reads this as the number 90; write "1:30" in quotes',
        'config.yaml: dataset.columns.plate_angle[1]: on: YAML reads this as true; write "on" in quotes',
        'config.yaml: publish.creators[0]: 1.50: YAML reads this as the number 1.5; write "1.50" in quotes',
    ])  # fmt: skip


@pytest.mark.parametrize(
    "text", ["+10", "10", "-0", ".5", "5.", "0.50", "007.5", "1.5e+1", "1.5E-1"]
)
def test_plain_numbers_are_as_they_are_read(write, text):
    key = "particle_velocity_y" if text == "-0" else "plate_angle"
    config = read_config(write(f"study: a\nsampling: {{ranges: {{{key}: {text}}}}}\n"))
    assert getattr(config.sampling.ranges, key)[0] == float(text)


CONTROL = [
    "a\x07b",
    "a\nb",
    "a\tb",
    "a\x00b",
    "a\x1b[2Kb",
    "a\x85b",
    "a\u2028b",
    "a\u202eb",
    "\x7f",
]
FREE_TEXT = [
    lambda text: {"publish": {"title": text}},
    lambda text: {"publish": {"creators": ["Ada", text]}},
    lambda text: {"dataset": {"external": text}},
    lambda text: {"dataset": {"external": "t.csv", "columns": {"plate_angle": text}}},
    lambda text: {"dataset": {"external": "t.csv", "columns": {"plate_angle": ["slope", text]}}},
    lambda text: {"dataset": {"external": "t.csv", "columns": {text: "slope"}}},
]


@pytest.mark.parametrize("at", range(len(FREE_TEXT)))
@pytest.mark.parametrize("text", [*CONTROL, " ", ""])
def test_control_characters_and_nothing_are_no_name(text, at):
    with pytest.raises(ConfigError) as error:
        load_config({"study": "a", **FREE_TEXT[at](text)})
    (line,) = error.value.problems
    code = next((f"U+{ord(char):04X}" for char in text if char not in "ab "), None)
    assert line.isprintable()
    assert f"contains the control character {code}" in line if code else "must " in line


@pytest.mark.parametrize(
    "text",
    ["Wear by {DEM}", "水 & Müller", "a_b_", "zero\u200dwidth", "\u00a0 no break", "x: y #z"],
)
@pytest.mark.parametrize("at", range(len(FREE_TEXT)))
def test_any_other_text_is_kept_as_it_is(write, text, at):
    config = load_config({"study": "a", **FREE_TEXT[at](text)})
    assert read_config(write(to_yaml(config), "resolved.yaml")) == config


@pytest.mark.parametrize(
    ("key", "value", "problem"),
    [
        ("creators", [], "must not be empty"),
        ("creators", [""], "must not be empty"),
        ("date", "2026-02-30", "there is no such day"),
        ("date", "2025-02-29", "there is no such day"),
        ("date", "0000-01-01", "there is no such day"),
        ("date", "2026-13-01", "has the wrong form"),
        ("date", "١٩٩٩-01-01", "has the wrong form"),
        ("version", "1.0", "has the wrong form"),
        ("version", "1.0.١", "has the wrong form"),
        ("url", "http://example.org", "has the wrong form"),
        ("url", "https://example.org/a b", "has the wrong form"),
        ("url", "https://example.org/{a}", "has the wrong form"),
        ("url", "https://example.org/<a>", "has the wrong form"),
        ("url", "https://example.org/a\\b", "has the wrong form"),
    ],
)
def test_metadata_that_an_archive_would_refuse_are_refused_at_the_start(key, value, problem):
    with pytest.raises(ConfigError) as error:
        load_config({"study": "a", "publish": {key: value}})
    (line,) = error.value.problems
    assert f": {problem}" in line


def test_missing_key_belongs_to_the_first_file(write):
    with pytest.raises(ConfigError, match=r"^config\.yaml: study: \(missing\): is required"):
        read_config(write("seed: 1\n"), write("sampling:\n  blocks: 1\n", "overlay.yaml"))


def test_a_byte_order_mark_is_no_mistake(write):
    assert read_config(write(b"\xef\xbb\xbfstudy: a\n")).study == "a"


@pytest.mark.parametrize(
    ("given", "found"),
    [
        ("{restitution: 0.35}", (0.35, 0.5, 0.01)),
        ("{static_friction: 0.3, rolling_friction: 0}", (0.5, 0.3, 0.0)),
        ("null", None),
    ],
)
def test_pairs_have_the_default_for_what_is_not_given_and_none_for_null(write, given, found):
    text = f"simulation: {{pair_interaction: {given}}}\n"
    for files in ([CONFIG, write(text, "over.yaml")], [write(f"study: a\n{text}", "alone.yaml")]):
        pair = setup_dict(read_config(*files))["pair_interaction"]
        assert (pair and tuple(pair.values())) == found


def test_overlay_is_merged_deeply_and_lists_are_replaced(write):
    base = write("study: a\nsampling:\n  blocks: 3\n  ranges:\n    restitution: [0.3, 0.4]\n")
    overlay = write("sampling:\n  ranges:\n    restitution: 0.5\n", "overlay.yaml")
    config = read_config(base, overlay)
    assert config.sampling.blocks == 3
    assert config.sampling.ranges.restitution == (0.5, 0.5)


def test_config_yaml_is_the_default_of_every_key():
    # Then the comments in config.yaml and the help texts describe the same study.
    assert read_config(CONFIG) == Config(study="paper")
    assert read_config(CONFIG).model_dump(mode="json") == yaml.safe_load(CONFIG.read_text())


def test_paper_study_is_what_the_paper_simulates():
    config = read_config(CONFIG)
    assert config.cases == 200
    assert config.sampling.method == "lhs"
    assert config.simulation.time_step_rayleigh_fraction == 0.2
    assert config.simulation.stop.window_s == 2.0
    for row in SAMPLED:
        assert tuple(sampled_ranges(config)[row.name]) == row.paper_range


@pytest.mark.parametrize("study", STUDIES, ids=lambda path: path.stem)
def test_every_study_is_a_valid_overlay(study):
    assert read_config(CONFIG, study).cases > 0


def test_grown_smoke_study_differs_in_the_number_of_blocks_only():
    smoke = read_config(CONFIG, ROOT / "studies/smoke.yaml").model_dump()
    grown = read_config(
        CONFIG, ROOT / "studies/smoke.yaml", ROOT / "studies/smoke_grown.yaml"
    ).model_dump()
    assert grown["sampling"].pop("blocks") == smoke["sampling"].pop("blocks") + 2
    assert grown == smoke


def test_schema_and_documentation_in_the_repository_are_the_generated_ones():
    hint = "run python -m abradem.config --write"
    assert json.loads((ROOT / reference.SCHEMA_FILE).read_text()) == schema(), hint
    assert (ROOT / reference.DOCUMENTATION_FILE).read_text() == documentation(), hint


def test_writing_regenerates_schema_and_documentation(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert reference.main(["--write"]) == 0
    assert (tmp_path / reference.DOCUMENTATION_FILE).read_text() == documentation()
    assert reference.main([]) == 2


def test_every_key_has_a_help_text():
    for key, field in explaining.leaves():
        assert field.description and field.description.endswith("."), key


def test_schema_refuses_unknown_keys_everywhere():
    sections = [schema(), *schema()["$defs"].values()]
    assert all(section["additionalProperties"] is False for section in sections)


@pytest.mark.parametrize(
    ("section", "name", "allowed"),
    [
        (simulation_keys.Contact, "normal", model.NORMAL_LAWS),
        (simulation_keys.Contact, "tangential", model.TANGENTIAL_LAWS),
        (simulation_keys.Contact, "tangential_damping", model.TANGENTIAL_DAMPINGS),
        (simulation_keys.Simulation, "stepping", model.STEPPINGS),
    ],
)
def test_options_are_those_of_the_engine(section, name, allowed):
    # They are repeated in abradem.config so that it need not import the engine.
    assert get_args(section.model_fields[name].annotation) == allowed


def test_default_setup_of_the_engine_is_the_dilute_study():
    dilute = read_config(CONFIG, ROOT / "studies/dilute.yaml")
    assert Setup.from_dict(setup_dict(dilute)) == model.Setup()


def test_setup_is_plain_data_and_names_every_field_of_the_engine(write):
    name = write(
        "study: a\nsimulation:\n  pair_interaction:\n"
        "    {restitution: 0.35, static_friction: 0.56, rolling_friction: 0.01}\n"
        "  factory: {feed: number, mass_rate_kg_s: null, number_rate_per_s: 500}\n"
    )
    plain = json.loads(json.dumps(setup_dict(read_config(name))))
    setup = Setup.from_dict(plain)
    assert setup.pair_interaction == model.Interaction(0.35, 0.56, 0.01)
    assert (setup.mass_rate, setup.number_rate) == (None, 500.0)
    # duration and an absolute time step are for benchmarks, not for studies; a geometry is there
    # if it is not the plate, and its surface and feed are made from it for each case.
    names = {field.name for field in dataclasses.fields(model.Setup)} - {"time_step", "duration"}
    assert set(plain) == names - {"geometry", "surface", "feed", "removal_box"}


def test_resolved_configuration_reads_back_as_itself(write):
    config = read_config(CONFIG, ROOT / "studies/smoke.yaml")
    assert read_config(write(to_yaml(config), "resolved.yaml")) == config


@given(radius=st.integers(1, 1000).map(lambda tenth: tenth / 10))
def test_millimetres_become_the_nearest_metres(radius):
    ranges = {"particle_radius_mm": radius}
    config = Config.model_validate({"study": "a", "sampling": {"ranges": ranges}})
    assert sampled_ranges(config)["particle_radius"] == [radius / 1000.0, radius / 1000.0]


@given(st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3)
    | st.dictionaries(st.sampled_from(["study", "sampling", "ranges", "restitution", "x"]), inner),
    max_leaves=10,
).filter(lambda value: isinstance(value, dict)))  # fmt: skip
def test_whatever_is_given_ends_in_a_configuration_or_in_one_line_per_problem(values):
    try:
        load_config(values)
    except ConfigError as error:
        assert error.problems
        assert all(len(problem.splitlines()) == 1 for problem in error.problems)


@pytest.mark.parametrize("compiled", [True, False])
def test_estimate_is_one_line_that_counts_cases_blocks_and_jobs(compiled, monkeypatch):
    monkeypatch.setattr(effort, "is_compiled", lambda stepping, on_surface: compiled)
    config = read_config(CONFIG, ROOT / "studies/smoke.yaml")
    line = estimate(config, cores=2)
    assert line.startswith("smoke: 12 cases in 2 blocks, 4 simulation jobs, simulated in about ")
    end = "" if compiled else f", after the engine is compiled, {effort.compiling_words()}"
    assert line.endswith(f" on 2 cores{end}")


def test_threads_change_no_setup_and_a_geometry_uses_one():
    """What determines a case is the set-up, which is a parameter of the rules."""
    one, four = (
        Config.model_validate({"study": "a", "simulation": {"threads": threads}})
        for threads in (1, 4)
    )
    assert setup_dict(one) == setup_dict(four)
    assert (one.threads, four.threads) == (1, 4)
    chute = {"kind": "mesh", "mesh": {"file": "chute.stl"}}
    study = {"study": "a", "simulation": {"threads": 4, "geometry": chute}}
    assert Config.model_validate(study).threads == 1


def seconds_told(config, cores):
    """The run time that the line states, s."""
    line = estimate(config, cores=cores)
    number, unit = re.search(r"about ([\d.]+) (\w+) on", line).groups()
    return float(number) * {"s": 1.0, "min": 60.0, "h": 3600.0}[unit]


def test_the_estimate_adds_up_cases_and_starts_of_jobs():
    """On a steep plate a case costs its particles, its simulated time and a constant."""

    def told(**changes):
        study = {
            "study": "a",
            "sampling": {
                "blocks": changes.get("blocks", 1),
                "ranges": {"particle_radius_mm": 10, "particle_density": 2500, "plate_angle": 70},
            },
            "simulation": {
                "cases_per_job": 1,
                "stop": {"window_s": 99, "max_time_s": 100},
                "factory": {
                    "mass_rate_kg_s": 4,
                    "patch_length_mm": 100,
                    "patch_width_mm": 100,
                    "fall_height_mm": 250,
                    "angle_acts": "tilt",
                    "arc_radius_mm": 0,
                },
            },
        }
        return seconds_told(Config.model_validate(study), changes.get("cores", 1))

    particles = 4.0 / (4.0 / 3.0 * math.pi * 0.01**3 * 2500.0) * 100.0
    case = COSTS.case + 100.0 * COSTS.second + particles * COSTS.particle
    least = 100.0 * (case + effort.SECONDS_PER_JOB)
    assert least <= told() <= 1.3 * least
    assert told(blocks=40) == pytest.approx(40.0 * told(), rel=0.1)
    assert told(blocks=40, cores=8) == pytest.approx(told(blocks=5), rel=0.1)


def test_the_estimate_is_at_least_the_time_of_the_most_expensive_batch():
    study = {
        "study": "a",
        "sampling": {
            "blocks": 1,
            "cases_per_block": 20,
            "ranges": {"particle_radius_mm": 5, "plate_angle": 0, "particle_velocity_y": -1},
        },
        "simulation": {"cases_per_job": 10},
    }
    config = Config.model_validate(study)
    alone = batch_seconds(
        block_cases(1, 0, 20, "lhs", sampled_ranges(config)), setup_dict(config), config.batches
    )
    assert seconds_told(config, cores=1) > 1.5 * seconds_told(config, cores=2)
    assert seconds_told(config, cores=100) == pytest.approx(max(map(sum, alone)), rel=0.05)


def test_a_table_is_asked_what_it_means():
    for stated, words in (((), "dataset.jet and dataset.rate unk"), (("jet",), "dataset.rate unk")):
        given = {"external": "t.csv", **dict.fromkeys(stated, "stated")}
        assert words in estimate(Config(study="a", dataset=given), 2)
    known = Config(study="a", dataset={"external": "t.csv", "jet": "stated", "rate": "stated"})
    assert estimate(known, 2) == "a: learning from t.csv, nothing is simulated"
    assert contacts_of(known) is None
    assert contacts_of(Config(study="a"))["pair_interaction"]["rolling_friction"] == 0.01
    assert jet_is_known(known) and jet_is_known(Config(study="a"))
    assert not jet_is_known(Config(study="a", dataset={"external": "t.csv"}))

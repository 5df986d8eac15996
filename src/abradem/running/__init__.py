"""Support for running the workflow: estimates, progress, logs, code hashes and provenance.

`effort` estimates the run time, `progress` and `job_log` report on a run, `code_hash` decides what
is rerun, and `provenance`, `rule_graph` and `run_times` record it.
"""

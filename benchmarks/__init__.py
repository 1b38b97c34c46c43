"""Measurements: ``python -m benchmarks NAME [--quick]`` writes JSON as measured, tables and pictures."""

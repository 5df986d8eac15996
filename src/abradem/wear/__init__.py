"""Wear rates and their standard errors, from the series and maps of simulations."""

"""Quantities that follow from a fit or from data: crossover, plateau, viscosity, linear limit ...

Each with its interval, and whether the data or the model say it.
"""

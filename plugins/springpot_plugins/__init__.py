"""Every built-in model, effect, optimiser, objective, data set and reader, loaded as any plugin."""

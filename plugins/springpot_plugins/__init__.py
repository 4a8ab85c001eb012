"""Every built-in model, effect, optimiser, objective, data set and reader, loaded like anybody else's plugin."""

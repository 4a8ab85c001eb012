"""The accuracy gate: whether an optimiser became worse than its committed baseline."""

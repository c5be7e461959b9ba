"""The four methods, one package each, and the contract they share (`base`)."""

"""The verbs of the command line, one module a verb: what it asks, what it answers, how it prints."""

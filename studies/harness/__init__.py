"""What every study shares: the command line, workers, resuming, provenance."""

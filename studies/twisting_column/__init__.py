"""The twisting column: robustness at large strain."""

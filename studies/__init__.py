"""Studies: each runs independent cases, returns tables, and has a report made from them."""

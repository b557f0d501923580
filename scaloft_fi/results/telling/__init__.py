"""How results are told: tables, rows, maps and pictures."""

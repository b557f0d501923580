"""What kills what: where mutants die, which situations are needed, where survivors stopped."""

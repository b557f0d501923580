"""What `scaloft-fi seek` finds in an hour for the mutants that the paper's grid does not detect."""

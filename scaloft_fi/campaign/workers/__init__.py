"""Who flies: processes of this machine, or a cluster."""

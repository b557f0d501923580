"""A campaign: planned flights, flown by workers, their outcomes in one store."""

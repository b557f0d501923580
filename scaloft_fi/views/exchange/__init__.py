"""The campaign in the formats of other tools, each a pure function of the same dossier."""

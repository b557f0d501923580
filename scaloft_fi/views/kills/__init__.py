"""Pages about kills and survivors: what kills what, and what to do about the rest."""

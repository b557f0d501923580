"""What a campaign says, as people and tools read it: tables, pictures, exchange formats, the report."""

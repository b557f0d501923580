"""Worker processes on this machine: start them, send them tasks, end them with their parent."""

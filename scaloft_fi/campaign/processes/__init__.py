"""Processes of this machine: started, sent tasks, ended with the process that started them."""

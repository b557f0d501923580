"""What each verb answers, one function a file: the verb prints it, and a script gets it as it is."""

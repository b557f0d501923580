"""`python -m scaloft_fi` is the command `scaloft-fi`."""

from scaloft_fi.cli.main import main

if __name__ == "__main__":
    main()

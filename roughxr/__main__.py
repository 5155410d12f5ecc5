"""``python -m roughxr``, where no script is installed."""

from .application.cli import main_of_process

if __name__ == "__main__":
    main_of_process()

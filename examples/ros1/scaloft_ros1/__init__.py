"""Topics of ROS 1 for stages of a drone in other processes, as a plugin of scaloft-fi."""

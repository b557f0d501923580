"""A mission of our own on the topics of the SCALOFT testbed: own_mission.py [PERSON].

ROUTE in the environment is a list of places [x, y, z] in JSON.  It flies to each, slows down for a person, gives up at
a contact, and lands at the last place.  PERSON is 1 where a person is put beside the corridor.
"""

import json
import math
import os
import sys

import rospy
from darknet_ros_msgs.msg import BoundingBoxes
from gazebo_msgs.msg import ContactsState, ModelState
from gazebo_msgs.srv import SetModelState
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from std_msgs.msg import Float32

RATE_HZ = 20
CRUISE_MPS, SLOW_MPS = 0.5, 0.2
NEAR_M = 0.15
PLACES = {"1": (-0.5, 3.25), "0": (10.0, 10.0)}


class Mission:
    """Follows the topics, and orders places and speeds."""

    def __init__(self, route):
        self.route = route
        self.place = None
        self.touched = False
        self.speed_mps = CRUISE_MPS
        self.goal = rospy.Publisher("/move_base_simple/goal", PoseStamped, queue_size=1)
        self.speed = rospy.Publisher("/drone_update_vel", Float32, queue_size=1)
        self.land = rospy.Publisher("/land_command", Float32, queue_size=1)
        rospy.Subscriber("/mavros/global_position/local", Odometry, self.moved, queue_size=1)
        rospy.Subscriber("/darknet_ros/bounding_boxes", BoundingBoxes, self.saw, queue_size=1)
        rospy.Subscriber("/gazebo_bumper", ContactsState, self.felt, queue_size=1)

    def moved(self, odometry):
        """Note where the drone is."""
        self.place = odometry.pose.pose.position

    def saw(self, boxes):
        """Slow down for a person, from now on."""
        if any(box.Class == "person" for box in boxes.bounding_boxes):
            self.speed_mps = SLOW_MPS
            self.speed.publish(Float32(SLOW_MPS))

    def felt(self, contacts):
        """Note a contact."""
        self.touched = self.touched or bool(contacts.states)

    def reached(self, x, y):
        """Whether the drone is at a place."""
        return self.place is not None and math.hypot(self.place.x - x, self.place.y - y) < NEAR_M

    def fly(self):
        """Fly the route; returns whether it was flown to its end."""
        rate = rospy.Rate(RATE_HZ)
        rate.sleep()
        self.speed.publish(Float32(self.speed_mps))
        for x, y, z in self.route:
            order = PoseStamped()
            order.pose.position.x, order.pose.position.y, order.pose.position.z = x, y, z
            while not self.reached(x, y):
                if self.touched:
                    return False
                self.goal.publish(order)
                rate.sleep()
        return True


def main(person="0"):
    """Put the person there, fly, and land."""
    rospy.init_node("own_mission")
    rospy.wait_for_service("/gazebo/set_model_state")
    state = ModelState(model_name="person")
    state.pose.position.x, state.pose.position.y = PLACES[person]
    assert rospy.ServiceProxy("/gazebo/set_model_state", SetModelState)(state).success
    mission = Mission(json.loads(os.environ["ROUTE"]))
    sys.stdout.write("flown\n" if mission.fly() else "given up: a contact\n")
    sys.stdout.flush()
    for _ in range(RATE_HZ):
        if not mission.touched:
            mission.land.publish(Float32())
        rospy.sleep(1.0 / RATE_HZ)


if __name__ == "__main__":
    main(*sys.argv[1:])

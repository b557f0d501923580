#!/bin/sh
# What the scripts of the testbed need of ROS 1 on Debian 12: its packages, and the messages that Debian lacks,
# generated from the definitions in messages/.
#
#     setup.sh [FOLDER]
#
# FOLDER gets the generated messages; by default it is where the system's Python looks.  With another one, have it in
# PYTHONPATH.  SKIP_APT=1 installs no packages.
set -eu

here=$(cd "$(dirname "$0")" && pwd)
folder=${1:-$(/usr/bin/python3 -c 'import sysconfig; print(sysconfig.get_path("purelib", "posix_local"))')}

if [ -z "${SKIP_APT:-}" ]; then
    apt-get update -qq
    apt-get install -y -qq --no-install-recommends \
        python3-rospy python3-rosmaster python3-rosgraph-msgs python3-genpy python3-genmsg python3-tf \
        python3-std-msgs python3-std-srvs python3-geometry-msgs python3-sensor-msgs python3-nav-msgs \
        ros-std-msgs ros-geometry-msgs python3-numpy python3-matplotlib
fi

generate() { # package, kind of definition, generator
    set -- "$1" "$2" "$3" "$here/messages/$1/$2"
    [ -d "$4" ] || return 0
    /usr/bin/python3 "/usr/lib/genpy/$3" -p "$1" -o "$folder/$1/$2" \
        -I "$1:$here/messages/$1/msg" -I std_msgs:/usr/share/std_msgs/msg -I geometry_msgs:/usr/share/geometry_msgs/msg \
        "$4"/*."$2"
    /usr/bin/python3 /usr/lib/genpy/genmsg_py.py --initpy -o "$folder/$1/$2" -p "$1"
}

for package in gazebo_msgs darknet_ros_msgs; do
    mkdir -p "$folder/$package"
    touch "$folder/$package/__init__.py"
    generate "$package" msg genmsg_py.py
    generate "$package" srv gensrv_py.py
done
echo "generated gazebo_msgs and darknet_ros_msgs in $folder"

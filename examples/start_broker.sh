#!/bin/sh
# Starts Mosquitto in FOLDER (/mosquitto if none is given), which holds config/mosquitto.conf and config/mosquitto.acl,
# with the users `service` and `fleet`. Their passwords come from the environment, MACTA_SERVICE_PASSWORD and
# MACTA_FLEET_PASSWORD. Robots that come by themselves are enrolled in data/ by `macta robot enrol --folder data`; or
# config/robots has a line NAME:PASSWORD for each.
#
#   sh start_broker.sh [FOLDER]
set -eu
PATH=$PATH:/usr/sbin
cd "${1:-/mosquitto}"

for password in "${MACTA_SERVICE_PASSWORD:?set it to a secret}" "${MACTA_FLEET_PASSWORD:?set it to a secret}"; do
    case $password in
        *:*) echo "MACTA_SERVICE_PASSWORD and MACTA_FLEET_PASSWORD must not contain a colon" >&2; exit 1 ;;
    esac
done

umask 077
mkdir -p data
begin='# begin of robots enrolled by `macta robot enrol`; do not edit'
end='# end of robots enrolled by `macta robot enrol`'
touch data/acl data/passwords
# What `macta robot enrol --folder data` has written stays: the robots' rights, and the digests of their passwords.
awk -v begin="$begin" -v end="$end" '$0 == begin { on = 1 } on { print } $0 == end { on = 0 }' data/acl > data/acl.enrolled
sed -n 's/^user //p' data/acl.enrolled | while read -r robot; do
    grep "^$robot:" data/passwords || true
done > data/passwords.enrolled

printf 'service:%s\nfleet:%s\n' "$MACTA_SERVICE_PASSWORD" "$MACTA_FLEET_PASSWORD" > data/passwords.new
if [ -f config/robots ]; then
    cat config/robots >> data/passwords.new
    cat data/acl.enrolled config/mosquitto.acl > data/acl.new
else
    # Nobody has rights by a name alone: enrolled robots have theirs listed.
    { grep -v '^pattern ' config/mosquitto.acl; cat data/acl.enrolled; } > data/acl.new
fi
mosquitto_passwd -U data/passwords.new
cat data/passwords.enrolled >> data/passwords.new
mv data/passwords.new data/passwords
mv data/acl.new data/acl
rm data/passwords.enrolled data/acl.enrolled
# Started as root, it becomes the user mosquitto. It is not given the keys that lie beside its files.
if [ "$(id -u)" = 0 ] && id mosquitto > /dev/null 2>&1; then
    chown mosquitto data data/acl data/passwords
    for kept in data/mosquitto.db*; do
        if [ -f "$kept" ]; then chown mosquitto "$kept"; fi
    done
fi
unset MACTA_SERVICE_PASSWORD MACTA_FLEET_PASSWORD
exec mosquitto -c config/mosquitto.conf

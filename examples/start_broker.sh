#!/bin/sh
# Starts Mosquitto in FOLDER (/mosquitto if none is given), which holds config/mosquitto.conf and config/mosquitto.acl,
# with the users `service` and `fleet`. Their passwords come from the environment, MACTA_SERVICE_PASSWORD and
# MACTA_FLEET_PASSWORD; those of robots that come by themselves from config/robots, a line NAME:PASSWORD each.
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
printf 'service:%s\nfleet:%s\n' "$MACTA_SERVICE_PASSWORD" "$MACTA_FLEET_PASSWORD" > data/passwords
if [ -f config/robots ]; then
    cat config/robots >> data/passwords
fi
mosquitto_passwd -U data/passwords
# Started as root, it becomes the user mosquitto.
if [ "$(id -u)" = 0 ] && id mosquitto > /dev/null 2>&1; then
    chown -R mosquitto data
fi
unset MACTA_SERVICE_PASSWORD MACTA_FLEET_PASSWORD
exec mosquitto -c config/mosquitto.conf

#!/bin/sh
# Installs the peers on Debian: Janus, and pion with the compiler for our forwarder. Needs to be root; about 600 MB.
set -eu
apt-get install -y --no-install-recommends iproute2 janus golang-go golang-github-pion-webrtc.v3-dev
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$here/build"
cd "$here/forwarder"
GO111MODULE=off GOFLAGS=-buildvcs=false GOPATH=/usr/share/gocode go build -o "$here/build/forwarder" main.go

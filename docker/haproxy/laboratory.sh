# A laboratory's certificates and scene (sourced by the tests of the composition).

# make_laboratory LISTEN: in this folder, laboratory.pem (its authority), server.pem and surgeon.pem
# of it, thief.pem of another one, their keys, and scene.textproto.
make_laboratory() {
  local name
  for name in laboratory strangers; do
    openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -keyout "$name.key" \
      -out "$name.pem" -subj "/CN=$name" -days 2 >>openssl.log 2>&1
  done
  issue server laboratory subjectAltName=DNS:localhost
  issue surgeon laboratory subjectAltName=DNS:surgeon
  issue thief strangers subjectAltName=DNS:surgeon
  chmod 600 ./*.key
  cat >scene.textproto <<SCENE
name: "behind haproxy"
server {
  listen: "$1"
  tls {
    certificate: "server.pem" key: "server.key" client_ca: "laboratory.pem"
    client { name: "surgeon" highest_priority: "operator" }
  }
}
device {
  name: "finger"
  simulated_finger {}
  finger_exoskeleton {}
  impedance { stiffness_n_per_m: 500 }
  limits { force_n: 10 }
}
SCENE
}
issue() { # issue NAME CA EXTENSIONS
  openssl req -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -keyout "$1.key" \
    -out "$1.csr" -subj "/CN=$1" >>openssl.log 2>&1
  openssl x509 -req -in "$1.csr" -CA "$2.pem" -CAkey "$2.key" -CAcreateserial -days 2 \
    -out "$1.pem" -extfile <(echo "$3") >>openssl.log 2>&1
}

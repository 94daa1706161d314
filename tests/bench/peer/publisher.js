// The client: publishes samples at a rate, dropping what the socket cannot take yet, as the
// client library does, and prints the service's percentiles of their age at use: "P50 P99" in microseconds.
//
//   node publisher.js ws://HOST:PORT SECONDS RATE_HZ
import { WebSocket } from 'ws';

const [url, seconds, rate] = process.argv.slice(2);
const SETTLING_S = 0.5; // not measured: the connection's first packets
const period_ms = 1000 / Number(rate);
const socket = new WebSocket(url, { perMessageDeflate: false });

let seq = 0;
function publish() {
  if (socket.bufferedAmount > 0) return; // the newest wins: this one would wait behind older ones
  socket.send(
    JSON.stringify({
      seq: ++seq,
      mode: 'held',
      source_time_ns: process.hrtime.bigint().toString(),
      position: [0.4, 0.5],
    }),
  );
}

socket.on('open', () => {
  socket._socket.setNoDelay(true);
  const start = performance.now();
  let next = start;
  let measuring = false;
  const timer = setInterval(() => {
    const now = performance.now();
    if (!measuring && now - start >= SETTLING_S * 1000) {
      measuring = true;
      socket.send(JSON.stringify({ begin: true }));
    }
    if (now - start >= (SETTLING_S + Number(seconds)) * 1000) {
      clearInterval(timer);
      socket.send(JSON.stringify({ report: true }));
      return;
    }
    if (now < next) return;
    while (next <= now) next += period_ms;
    publish();
  }, 1);
});
socket.on('message', (data) => {
  const { p50, p99 } = JSON.parse(data);
  console.log(`${p50} ${p99}`);
  socket.close();
});
socket.on('error', (error) => {
  console.error(`publisher.js: ${url}: ${error.message}`);
  process.exit(1);
});

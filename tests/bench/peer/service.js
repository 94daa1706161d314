// The service: keeps the newest sample, as hapticd does, and uses it once per millisecond. Says how
// old the samples were when they were used, by the steady clock that all programs of this host share.
//
//   node service.js          prints the port on which it listens on 127.0.0.1
import { WebSocketServer } from 'ws';

const PERIOD_NS = 1_000_000n;

/** Nearest rank; `sorted` ascending. */
function percentile(sorted, p) {
  const rank = Math.min(sorted.length - 1, Math.floor(p * sorted.length));
  return sorted.length === 0 ? 0 : sorted[rank];
}

const server = new WebSocketServer({ host: '127.0.0.1', port: 0, perMessageDeflate: false });
server.on('listening', () => console.log(server.address().port));
server.on('connection', (socket) => {
  socket._socket.setNoDelay(true);
  let newest = null;
  let ages = [];
  let next = process.hrtime.bigint();
  let timer = null;

  // Node's timers count whole milliseconds: the grid is kept here, a missed period is used late,
  // and once.
  const tick = () => {
    const now = process.hrtime.bigint();
    if (newest && now >= next) ages.push(Number(now - BigInt(newest.source_time_ns)) / 1000);
    while (next <= now) next += PERIOD_NS;
    timer = setTimeout(tick, 1);
  };
  tick();

  socket.on('message', (data) => {
    const message = JSON.parse(data);
    if (message.begin) {
      ages = [];
    } else if (message.report) {
      ages.sort((a, b) => a - b);
      socket.send(JSON.stringify({ p50: percentile(ages, 0.5), p99: percentile(ages, 0.99) }));
    } else if (!newest || message.seq > newest.seq) {
      newest = message;
    }
  });
  socket.on('close', () => clearTimeout(timer));
  socket.on('error', () => clearTimeout(timer));
});

#include "haptic_board.h"

enum {
  HELLO_SIZE = 5,
  ARM_SIZE = 4,
  COMMAND_HEADER = 6,
  SERIAL_WIDTH = 16,
  MODEL_WIDTH = 24,
  NAME_WIDTH = 16
};

static bool has_capability(const hb_board* board, enum hb_capability which) {
  return (board->config->capabilities & (unsigned)which) != 0;
}

static void transmit(hb_board* board, enum hf_type type, const uint8_t* end) {
  /* A number is used up even if there is no room: the host counts what is missing. */
  const uint32_t seq = ++board->tx_seq;
  const size_t length =
      hf_encode((uint8_t)type, seq, board->payload, (size_t)(end - board->payload), board->wire);
  if (!board->send(board->context, board->wire, length)) ++board->counters.states_dropped;
}

static void let_go(hb_board* board, hb_state state) {
  board->state = state;
  for (size_t i = 0; i < HB_MAX_DOFS; ++i) board->reference[i] = 0.0f;
}

void hb_init(hb_board* board, const hb_config* config, hb_send send, void* context) {
  uint8_t* const bytes = (uint8_t*)board;
  for (size_t i = 0; i < sizeof *board; ++i) bytes[i] = 0;
  board->config = config;
  board->send = send;
  board->context = context;
  for (uint8_t i = 0; i < config->n_q; ++i) {
    if (config->dofs[i].actuated) ++board->n_a;
  }
  let_go(board, HB_DISARMED);
}

/* ---- handshake -------------------------------------------------------------------------------- */

static void send_identity(hb_board* board, uint32_t session) {
  const hb_config* const c = board->config;
  uint8_t* to = board->payload;
  *to++ = HB_PROTOCOL_VERSION;
  *to++ = c->n_q;
  *to++ = board->n_a;
  *to++ = c->capabilities;
  to = hf_put_u32(to, session);
  to = hf_put_u32(to, c->watchdog_us);
  to = hf_put_u32(to, c->sample_period_us);
  for (size_t i = 0; i < 3; ++i) *to++ = c->firmware[i];
  *to++ = 0;
  to = hf_put_text(to, c->serial, SERIAL_WIDTH);
  to = hf_put_text(to, c->model, MODEL_WIDTH);
  transmit(board, HF_IDENTITY, to);
}

static void send_dof(hb_board* board, uint8_t index) {
  const hb_dof* const dof = &board->config->dofs[index];
  uint8_t* to = board->payload;
  *to++ = index;
  *to++ = dof->radian ? 1 : 0;
  *to++ = dof->actuated ? 1 : 0;
  *to++ = 0;
  to = hf_put_f32(to, dof->lower);
  to = hf_put_f32(to, dof->upper);
  to = hf_put_f32(to, dof->max_effort);
  to = hf_put_f32(to, dof->max_rate);
  to = hf_put_text(to, dof->name, NAME_WIDTH);
  transmit(board, HF_DOF, to);
}

/* True if the frame in the decoder is newer than the last one accepted (RFC 1982 arithmetic). */
static bool newer(const hb_board* board) {
  const uint32_t ahead = board->decoder.seq - board->rx_seq;
  return ahead != 0 && ahead < 0x80000000u;
}

static void on_hello(hb_board* board) {
  const uint8_t version = board->decoder.payload[0];
  const uint32_t session = hf_get_u32(board->decoder.payload + 1);
  if (version == HB_PROTOCOL_VERSION && session != board->session) {
    board->session = session;
    board->nonce = 0;
    board->command_seq = 0;
    ++board->counters.sessions;
    let_go(board, HB_DISARMED);
  }
  /* A host of another version learns this board's version and gets no session. */
  send_identity(board, session);
  for (uint8_t i = 0; i < board->config->n_q; ++i) send_dof(board, i);
}

/* ---- arming and commands ---------------------------------------------------------------------- */

static bool on_arm(hb_board* board, uint64_t now_us) {
  const uint32_t nonce = hf_get_u32(board->decoder.payload);
  if (nonce == board->last_nonce) return false;
  if (board->faults != 0) return true; /* heard, not followed: the state says why */
  board->nonce = board->last_nonce = nonce;
  board->command_seq = 0;
  board->command_at = now_us; /* the watchdog runs from here on */
  let_go(board, HB_ARMED);
  return true;
}

static bool command_is_well_formed(const hb_board* board) {
  const hf_decoder* const d = &board->decoder;
  if (d->payload_length < COMMAND_HEADER) return false;
  if (d->payload[5] != board->n_a) return false;
  if (d->payload_length != COMMAND_HEADER + 4u * board->n_a) return false;
  if (d->payload[4] == HB_POSITION) {
    if (!has_capability(board, HB_POSITION_COMMAND)) return false;
  } else if (d->payload[4] != HB_FORCE) {
    return false;
  }
  for (size_t i = 0; i < board->n_a; ++i) {
    if (!hf_is_finite(hf_get_f32(d->payload + COMMAND_HEADER + 4u * i))) return false;
  }
  return true;
}

static float clamp(float value, float lower, float upper) {
  return value < lower ? lower : value > upper ? upper : value;
}

static bool on_command(hb_board* board, uint64_t now_us) {
  const hf_decoder* const d = &board->decoder;
  if (board->state != HB_ARMED || hf_get_u32(d->payload) != board->nonce) return false;
  board->kind = d->payload[4] == HB_POSITION ? HB_POSITION : HB_FORCE;
  size_t a = 0;
  for (uint8_t i = 0; i < board->config->n_q; ++i) {
    const hb_dof* const dof = &board->config->dofs[i];
    if (!dof->actuated) continue;
    const float wanted = hf_get_f32(d->payload + COMMAND_HEADER + 4u * a);
    board->reference[a++] = board->kind == HB_POSITION
                                ? clamp(wanted, dof->lower, dof->upper)
                                : clamp(wanted, -dof->max_effort, dof->max_effort);
  }
  board->command_seq = d->seq;
  board->command_at = now_us;
  return true;
}

/* Length and content of the frame in the decoder are what its type demands. */
static bool well_formed(const hb_board* board) {
  const hf_decoder* const d = &board->decoder;
  switch (d->type) {
    case HF_HELLO:
      return d->payload_length == HELLO_SIZE && hf_get_u32(d->payload + 1) != 0;
    case HF_ARM:
      return d->payload_length == ARM_SIZE && hf_get_u32(d->payload) != 0;
    case HF_DISARM:
      return d->payload_length == 0;
    case HF_COMMAND:
      return command_is_well_formed(board);
    default:
      return false;
  }
}

static bool starts_session(const hb_board* board) {
  return board->decoder.type == HF_HELLO &&
         hf_get_u32(board->decoder.payload + 1) != board->session;
}

static void on_frame(hb_board* board, uint64_t now_us) {
  if (!well_formed(board)) {
    ++board->counters.malformed;
    return;
  }
  if (!starts_session(board) && (board->session == 0 || !newer(board))) {
    ++board->counters.not_newer;
    return;
  }
  board->rx_seq = board->decoder.seq;
  bool right_nonce = true;
  switch (board->decoder.type) {
    case HF_HELLO:
      on_hello(board);
      break;
    case HF_ARM:
      right_nonce = on_arm(board, now_us);
      break;
    case HF_DISARM:
      if (board->state == HB_ARMED) {
        board->nonce = 0;
        let_go(board, HB_DISARMED);
      }
      break;
    default:
      right_nonce = on_command(board, now_us);
      break;
  }
  if (right_nonce) {
    ++board->counters.accepted;
  } else {
    ++board->counters.wrong_nonce;
  }
}

static void watch(hb_board* board, uint64_t now_us) {
  if (board->state != HB_ARMED || now_us - board->command_at <= board->config->watchdog_us) return;
  ++board->counters.watchdog_stops;
  let_go(board, HB_STOPPED);
}

void hb_receive(hb_board* board, uint8_t byte, uint64_t now_us) {
  watch(board, now_us); /* first: a command that comes too late must not revive an arming */
  switch (hf_push(&board->decoder, byte)) {
    case HF_FRAME:
      on_frame(board, now_us);
      break;
    case HF_MALFORMED:
      ++board->counters.malformed;
      break;
    case HF_BAD_CRC:
      ++board->counters.bad_crc;
      break;
    case HF_NONE:
      break;
  }
}

/* ---- samples ---------------------------------------------------------------------------------- */

static uint8_t stuck_sensors(hb_board* board, const float* q) {
  uint8_t faults = 0;
  for (uint8_t i = 0; i < board->config->n_q; ++i) {
    const uint16_t limit = board->config->dofs[i].stuck_after;
    if (limit == 0) continue;
    /* Two comparisons, because a NaN is not even equal to itself. */
    const bool moved = q[i] < board->last_q[i] || q[i] > board->last_q[i];
    board->last_q[i] = q[i];
    if (moved) board->same_for[i] = 0;
    if (board->same_for[i] >= limit) {
      faults = HB_SENSOR_STUCK;
    } else {
      ++board->same_for[i];
    }
  }
  return faults;
}

static void send_state(hb_board* board, uint64_t now_us, const float* q, const float* force) {
  const uint64_t age = now_us - board->command_at;
  const bool heard = board->command_seq != 0 && age < 65535u;
  uint8_t* to = board->payload;
  to = hf_put_u64(to, now_us);
  to = hf_put_u32(to, board->nonce);
  to = hf_put_u32(to, board->command_seq);
  to = hf_put_u16(to, heard ? (uint16_t)age : (uint16_t)65535u);
  *to++ = (uint8_t)board->state;
  *to++ = board->faults;
  *to++ = board->config->n_q;
  *to++ = force != NULL ? board->n_a : 0;
  for (uint8_t i = 0; i < board->config->n_q; ++i) to = hf_put_f32(to, q[i]);
  for (uint8_t i = 0; force != NULL && i < board->n_a; ++i) to = hf_put_f32(to, force[i]);
  transmit(board, HF_STATE, to);
}

static void send_counters(hb_board* board) {
  const hb_counters* const c = &board->counters;
  uint8_t* to = board->payload;
  to = hf_put_u32(to, c->accepted);
  to = hf_put_u32(to, c->bad_crc);
  to = hf_put_u32(to, c->malformed);
  to = hf_put_u32(to, c->not_newer);
  to = hf_put_u32(to, c->wrong_nonce);
  to = hf_put_u32(to, c->watchdog_stops);
  to = hf_put_u32(to, c->states_dropped);
  to = hf_put_u32(to, c->sessions);
  transmit(board, HF_COUNTERS, to);
}

void hb_sample(hb_board* board, uint64_t now_us, const float* q, const float* force,
               uint8_t faults) {
  watch(board, now_us);
  board->faults = (uint8_t)(faults | stuck_sensors(board, q));
  if (board->faults != 0) let_go(board, HB_FAULT);
  if (board->session == 0) return;
  send_state(board, now_us, q, force);
  if (now_us - board->counters_at < HB_COUNTERS_PERIOD_US) return;
  board->counters_at = now_us;
  send_counters(board);
}

bool hb_reference(hb_board* board, uint64_t now_us, float* reference, hb_kind* kind) {
  watch(board, now_us);
  for (size_t i = 0; i < board->n_a; ++i) reference[i] = board->reference[i];
  *kind = board->kind;
  /* Armed, but nothing commanded yet: there is nothing to follow, a position least of all. */
  return board->state == HB_ARMED && board->command_seq != 0;
}

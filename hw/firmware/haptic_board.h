/* The board's side of the protocol of hw/README.md: handshake, arming, watchdog, streaming.
 *
 *                HELLO of a new session                    ARM with a new nonce
 *   (power on) ------------------------> DISARMED ----------------------------> ARMED
 *                                           ^  ^------------ DISARM -------------+ |
 *                                           |                                      |
 *   STOPPED: no valid COMMAND for watchdog_us   <----------------------------------+
 *   FAULT:   a fault was reported to hb_sample  <----------------------------------+ (any state)
 *   Both are latched: only ARM with a new nonce (and no fault present) leads out, to ARMED; or a
 *   new session, to DISARMED.
 *
 * How to use it: fill hb_config; hb_init at power on; hb_receive for every byte that arrives;
 * hb_sample once per sample period; hb_reference before every control step, and switch the drive
 * off whenever it returns false. All calls from one context, or with interrupts masked. now_us is
 * one clock that never goes back. No call blocks, allocates or keeps a pointer into its arguments
 * (but the configuration's). RAM: sizeof(hb_board). */
#ifndef HAPTIC_BOARD_H
#define HAPTIC_BOARD_H

#include "haptic_frame.h"

#ifdef __cplusplus
extern "C" {
#endif

#define HB_PROTOCOL_VERSION 1u
#define HB_MAX_DOFS 24u
#define HB_COUNTERS_PERIOD_US 100000u

typedef enum { HB_DISARMED = 0, HB_ARMED = 1, HB_STOPPED = 2, HB_FAULT = 3 } hb_state;
typedef enum { HB_FORCE = 0, HB_POSITION = 1 } hb_kind;

enum hb_capability {
  HB_FORCE_LOOP = 1,      /* closes the loop on the measured force itself */
  HB_MEASURES_FORCE = 2,  /* STATE carries a force per actuated DoF */
  HB_POSITION_COMMAND = 4 /* follows HB_POSITION */
};
enum hb_fault {
  HB_FORCE_OVER_LIMIT = 1,
  HB_SENSOR_STUCK = 2, /* the very same reading for too long */
  HB_SENSOR_RANGE = 4, /* it reads what it cannot: broken wire, shorted */
  HB_ACTUATOR = 8,     /* over-current, over-temperature, no motion although there must be one */
  HB_SUPPLY = 16       /* under-voltage */
};

/* One entry of the DoF dictionary. m and N, or rad and N m. */
typedef struct {
  const char* name; /* 1..16 characters */
  bool radian;
  bool actuated;
  float lower, upper;         /* lower < upper */
  float max_effort, max_rate; /* of actuated DoFs, > 0 */
  /* This many readings in a row that are equal to the last bit mean that the sensor is stuck; 0:
   * never. Only for sensors whose noise exceeds their quantum, for example behind a 12-bit ADC. */
  uint16_t stuck_after;
} hb_dof;

typedef struct {
  const char* serial; /* up to 16 characters, unique per board */
  const char* model;  /* up to 24 */
  uint8_t firmware[3];
  uint8_t capabilities; /* hb_capability */
  uint32_t watchdog_us; /* longer than the server's loop_late_fault: 10000 or 25000 */
  uint32_t sample_period_us;
  const hb_dof* dofs;
  uint8_t n_q; /* 1..HB_MAX_DOFS */
} hb_config;

/* Takes a whole frame, or nothing and returns false if there is no room. Never blocks. */
typedef bool (*hb_send)(void* context, const uint8_t* bytes, size_t length);

typedef struct {
  uint32_t accepted, bad_crc, malformed, not_newer, wrong_nonce;
  uint32_t watchdog_stops, states_dropped, sessions;
} hb_counters;

typedef struct {
  const hb_config* config;
  hb_send send;
  void* context;
  hf_decoder decoder;
  hb_counters counters;
  hb_state state;
  uint8_t n_a;
  uint8_t faults; /* present in the last sample */
  uint32_t session;
  uint32_t nonce, last_nonce;
  uint32_t rx_seq, tx_seq;
  uint32_t command_seq;
  uint64_t command_at, counters_at; /* us */
  hb_kind kind;
  float reference[HB_MAX_DOFS]; /* n_a */
  float last_q[HB_MAX_DOFS];
  uint16_t same_for[HB_MAX_DOFS];
  uint8_t wire[HF_MAX_WIRE];
  uint8_t payload[HF_MAX_PAYLOAD];
} hb_board;

void hb_init(hb_board* board, const hb_config* config, hb_send send, void* context);

void hb_receive(hb_board* board, uint8_t byte, uint64_t now_us);

/* q: n_q readings at now_us. force: n_a readings, or NULL if there is no such sensor. faults:
 * hb_fault bits that are true now. Sends STATE, and COUNTERS every 100 ms, once a host said
 * HELLO. */
void hb_sample(hb_board* board, uint64_t now_us, const float* q, const float* force,
               uint8_t faults);

/* The references to follow now, n_a values within the dictionary's limits, and their kind. False:
 * the drive must be off, and the references are 0. */
bool hb_reference(hb_board* board, uint64_t now_us, float* reference, hb_kind* kind);

#ifdef __cplusplus
}
#endif

#endif

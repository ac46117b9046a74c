// What a call came to, and what happened to the lines. Every caller checks.
#ifndef LAMELLA_FIRMWARE_STATUS_H
#define LAMELLA_FIRMWARE_STATUS_H

enum lam_status {
  LAM_OK = 0,
  LAM_BAD_INPUT,    // a file or a message is wrong; no line moved
  LAM_WRONG_STATE,  // not now; no line moved
  LAM_UNSAFE,       // the plan breaks a rule; no line moved
  LAM_STORE_FULL,   // no room for a photograph; lights are off
  LAM_HARDWARE,     // a device did not do as told; lights are off
  LAM_DROPPED,      // a camera took no photograph; nothing else is wrong, no line moved
};

// Which part of the rig a failure is of: what the operator's panel tells.
enum lam_part {
  LAM_PART_OTHER = 0,
  LAM_PART_ESTOP,
  LAM_PART_HEAT,
  LAM_PART_CAMERA,
  LAM_PART_ACTUATOR,
  LAM_PART_LED_CHAIN,
  LAM_PART_DISK,
  LAM_PART_PROJECTOR,
};

#endif

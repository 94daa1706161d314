-- Wireshark's view of hapticd's datagrams (proto/README.md, "The UDP path"): what stands in the
-- clear, and what is wrong with it. The payload stays sealed; keys are never in a file.
--
--   tshark -X lua_script:proto/hapticd.lua -r capture.pcap -Y hapticd
--   wireshark -X lua_script:proto/hapticd.lua
--
-- Datagrams are known by their first bytes, whatever the port; "Decode As... HAPTICD" shows those
-- whose first bytes are wrong too.

local hapticd = Proto("hapticd", "hapticd datagram")

local TYPES = {
  [1] = "PROXY", [2] = "STATE", [3] = "PATH_CHALLENGE", [4] = "PATH_RESPONSE", [5] = "CLOSE",
}
local MAGIC, VERSION = 0x6870, 1
local HEADER, TAG, LARGEST = 16, 16, 1200
local REPLAY_WINDOW = 1024
-- A challenge and its response have at least this payload; a CLOSE has none.
local LEAST_PAYLOAD = { [3] = 40, [4] = 40 }

local f = {
  magic = ProtoField.uint16("hapticd.magic", "Magic", base.HEX),
  version = ProtoField.uint8("hapticd.version", "Version"),
  type = ProtoField.uint8("hapticd.type", "Type", base.DEC, TYPES),
  path_id = ProtoField.uint32("hapticd.path_id", "Path id", base.HEX),
  number = ProtoField.uint64("hapticd.packet_number", "Packet number"),
  ciphertext = ProtoField.bytes("hapticd.ciphertext", "Ciphertext"),
  payload = ProtoField.uint16("hapticd.payload_length", "Payload length"),
  tag = ProtoField.bytes("hapticd.tag", "Tag"),
}
hapticd.fields = f

local function warning(name, text)
  return ProtoExpert.new("hapticd." .. name, text, expert.group.PROTOCOL, expert.severity.WARN)
end
local e = {
  length = warning("bad_length", "Length is not 32..1200"),
  magic = warning("bad_magic", "Magic is not 68 70"),
  version = warning("bad_version", "Version is not 1"),
  type = warning("bad_type", "Type is not 1..5"),
  number = warning("bad_number", "Packet number is not above 0"),
  payload = warning("bad_payload", "Payload is not as long as its type demands"),
  repeated = warning("repeated", "This packet number was seen before: it will be rejected"),
  too_old = warning("too_old",
    "Packet number is 1024 or more below the newest: it will be rejected"),
}
hapticd.experts = e

-- Packet numbers by flow and path id, in the order of the capture: the first pass fills them, and
-- what it found of a frame stays.
local flows, verdicts

function hapticd.init()
  flows, verdicts = {}, {}
end

local function look_back(pinfo, path_id, number)
  if verdicts[pinfo.number] ~= nil then return verdicts[pinfo.number] end
  local key = string.format("%s:%d>%s:%d/%x", tostring(pinfo.src), pinfo.src_port,
                            tostring(pinfo.dst), pinfo.dst_port, path_id)
  local flow = flows[key] or { seen = {}, newest = UInt64(0) }
  flows[key] = flow
  local verdict = false
  if flow.seen[tostring(number)] then
    verdict = e.repeated
  elseif number + UInt64(REPLAY_WINDOW) <= flow.newest then
    verdict = e.too_old
  end
  flow.seen[tostring(number)] = true
  if number > flow.newest then flow.newest = number end
  verdicts[pinfo.number] = verdict
  return verdict
end

local function check(buffer, tree)
  local size, kind = buffer:len(), buffer(3, 1):uint()
  if size > LARGEST then tree:add_proto_expert_info(e.length) end
  if buffer(0, 2):uint() ~= MAGIC then tree:add_proto_expert_info(e.magic) end
  if buffer(2, 1):uint() ~= VERSION then tree:add_proto_expert_info(e.version) end
  if TYPES[kind] == nil then tree:add_proto_expert_info(e.type) end
  if buffer(8, 8):uint64() == UInt64(0) then tree:add_proto_expert_info(e.number) end
  local payload = size - HEADER - TAG
  if payload < (LEAST_PAYLOAD[kind] or 0) or (kind == 5 and payload > 0) then
    tree:add_proto_expert_info(e.payload)
  end
end

function hapticd.dissector(buffer, pinfo, root)
  local size = buffer:len()
  pinfo.cols.protocol = "HAPTICD"
  local tree = root:add(hapticd, buffer())
  if size < HEADER + TAG then
    tree:add_proto_expert_info(e.length)
    pinfo.cols.info = string.format("%d bytes: too short", size)
    return size
  end
  tree:add(f.magic, buffer(0, 2))
  tree:add(f.version, buffer(2, 1))
  tree:add(f.type, buffer(3, 1))
  tree:add(f.path_id, buffer(4, 4))
  tree:add(f.number, buffer(8, 8))
  local payload = size - HEADER - TAG
  if payload > 0 then tree:add(f.ciphertext, buffer(HEADER, payload)) end
  tree:add(f.payload, buffer(HEADER, payload), payload):set_generated()
  tree:add(f.tag, buffer(size - TAG, TAG))
  check(buffer, tree)
  local number, path_id = buffer(8, 8):uint64(), buffer(4, 4):uint()
  local late = look_back(pinfo, path_id, number)
  if late then tree:add_proto_expert_info(late) end
  local kind = TYPES[buffer(3, 1):uint()] or string.format("type %d", buffer(3, 1):uint())
  pinfo.cols.info = string.format("%s path %08x #%s, %d bytes of payload", kind, path_id,
                                  tostring(number), payload)
  return size
end

local function recognise(buffer, pinfo, root)
  if buffer:len() < HEADER + TAG or buffer(0, 2):uint() ~= MAGIC then return false end
  hapticd.dissector(buffer, pinfo, root)
  return true
end

hapticd:register_heuristic("udp", recognise)
DissectorTable.get("udp.port"):add_for_decode_as(hapticd)

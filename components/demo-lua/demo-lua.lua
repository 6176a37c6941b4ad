-- Codels of the demonstration component: they move one axis, one period at a time.

local demo = require "demo_types"

local PERIOD <const> = 0.005 -- of task main, s
local ACCELERATION <const> = 2.0 -- and deceleration, m/s2
local SPEED <const> = 0.5 -- before the first set_speed, m/s
local SPEEDS <const> = { 0.0, 2.0 } -- that set_speed accepts, m/s
local GOALS <const> = { -10.0, 10.0 } -- that goto accepts, m

-- Raises OUT_OF_RANGE for what is not accepted, also for NaN.
local function check(value, accepted, what)
    local lower, upper = accepted[1], accepted[2]
    if not (lower <= value and value <= upper) then
        error(demo.OUT_OF_RANGE { value = value, lower = lower, upper = upper, what = what })
    end
end

-- Permanent activity of task main, state start.
function demo_init(ids, position)
    ids.velocity = SPEED
    ids.current = { position = 0.0, velocity = 0.0 }
    ids.halted = false
    position:write(ids.current)
    return "ether"
end

-- Validation codel of attribute set_speed.
function demo_check_velocity(velocity)
    check(velocity, SPEEDS, "velocity, m/s")
end

-- Validation codel of activity goto.
function demo_check_goal(goal)
    check(goal, GOALS, "goal, m")
end

-- Codel of function reset.
function demo_reset(current)
    if current.velocity ~= 0.0 then error(demo.MOVING) end
    current.position = 0.0
end

-- Activity goto, state start.
function demo_begin(halted)
    halted.value = false
    return "main"
end

-- Activity goto, state main: one step towards the goal. The speed grows with the acceleration of the
-- axis, and is such that the axis can still stop at the goal with it. The last step ends exactly there.
function demo_servo(goal, velocity, halted, current, parameter, position)
    if halted then error(demo.HALTED) end
    local gain = parameter:latest()
    -- 1 if the port was never written; 0 for negative gains and NaN.
    if gain == nil then gain = 1.0 elseif not (gain > 0.0) then gain = 0.0 end
    local distance = goal - current.position
    local sign = distance < 0.0 and -1.0 or 1.0
    local speed = math.min(
        math.max(sign * current.velocity, 0.0) + ACCELERATION * PERIOD,
        velocity * gain,
        SPEEDS[2],
        math.sqrt(2.0 * ACCELERATION * math.abs(distance))
    )
    local arrived = math.abs(distance) <= speed * PERIOD
    if arrived then
        current.position, current.velocity = goal, 0.0
    else
        current.position = current.position + sign * speed * PERIOD
        current.velocity = sign * speed
    end
    position:write(current)
    return arrived and "ether" or "pause::main"
end

-- Activity goto, state stop: slows down until the axis stands still.
function demo_brake(current, position)
    local sign = current.velocity < 0.0 and -1.0 or 1.0
    local speed = math.max(math.abs(current.velocity) - ACCELERATION * PERIOD, 0.0)
    current.position = current.position + sign * speed * PERIOD
    current.velocity = speed > 0.0 and sign * speed or 0.0
    position:write(current)
    return speed > 0.0 and "pause::stop" or "ether"
end

-- Activity goto, event emergency: stops the axis at once. State main of the activity stays active
-- besides: its codel sees `halted` and ends with HALTED.
function demo_halt(current, halted, position)
    current.velocity = 0.0
    halted.value = true
    position:write(current)
    return "ether"
end

-- Codels of %NAME%: `%NAME%.gen` says when each is called, and with what.

local types = require "%NAME%_types"

local PERIOD <const> = 0.01 -- seconds, as in the description
local GREATEST <const> = 2.0 -- metres per second

-- Validates the inputs of attribute set_speed.
function %NAME%_check_speed(speed)
    if not (0.0 < speed and speed <= GREATEST) then
        error(types.e_out_of_range { greatest = GREATEST })
    end
end

-- Task motion begins.
function %NAME%_begin(ids)
    ids.position = 0.0
    ids.speed = 0.5
    return "shown"
end

-- Each period: what others read.
function %NAME%_show(position, current)
    current.data.position = position
    current:write()
    return "pause::shown"
end

-- Each period while moving.
function %NAME%_step(goal, speed, position)
    local left = goal - position.value
    local step = speed * PERIOD
    if math.abs(left) <= step then
        position.value = goal
        return "ether"
    end
    position.value = position.value + (left > 0.0 and step or -step)
    return "pause::start"
end

-- Interrupted: it stays where it is.
function %NAME%_halt()
    return "ether"
end

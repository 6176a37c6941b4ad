-- What scripts have besides the libraries of Lua: exceptions, ports, remotes, the module `genom`. It gets
-- functions of the runner, and returns those that the runner calls.
local raw = ...
local OWN = "=[genom]"

local error, getmetatable, setmetatable, pairs, rawget, select, tonumber, tostring, type =
    error, getmetatable, setmetatable, pairs, rawget, select, tonumber, tostring, type
local getinfo, getlocal, traceback = debug.getinfo, debug.getlocal, debug.traceback
local create, resume, yield = coroutine.create, coroutine.resume, coroutine.yield

-- The event of an exception, or of a class of exceptions; nil of other errors.
local function event_of(value)
    if type(value) ~= "table" then return nil end
    local meta = getmetatable(value)
    return rawget(value, "__event") or (type(meta) == "table" and rawget(meta, "__event")) or nil
end

-- The first line of a script at this level of the stack, or above.
local function line_of(level)
    while true do
        local info = getinfo(level, "Sl")
        if not info then return nil end
        if info.currentline > 0 and info.source ~= OWN then
            return (info.source:gsub("^[@=]", "")), info.currentline
        end
        level = level + 1
    end
end

-- The text of an error, without the place that Lua puts before it.
local function text_of(value, line)
    local text = tostring(value):gsub("^runtime error: ", ""):gsub("\nstack traceback:.*", "")
    local at, rest = text:match("^[^\n]-:(%d+): (.*)$")
    return tonumber(at) == line and rest or text
end

-- The handler of errors: an exception as it is, anything else with its lines.
local function failed(value)
    if event_of(value) then return value end
    local file, line = line_of(3)
    return { text = text_of(value, line), file = file, line = line, trace = traceback("", 2) }
end

-- A class of exceptions: called with a table of members, it makes one.
local function class(event, names)
    local made = { __event = event, __name = event }
    function made.__tostring(self)
        local all = {}
        for _, name in ipairs(names) do
            if self[name] ~= nil then all[#all + 1] = name .. " = " .. tostring(self[name]) end
        end
        return event .. " {" .. table.concat(all, ", ") .. "}"
    end
    local known = {}
    for _, name in ipairs(names) do known[name] = true end
    return setmetatable(made, {
        __tostring = function() return event end,
        __call = function(_, members)
            local exception = {}
            for name, value in pairs(members or {}) do
                if not known[name] then
                    error(event .. " has no member `" .. tostring(name) .. "`", 2)
                end
                exception[name] = value
            end
            return setmetatable(exception, made)
        end,
    })
end

-- The names of a function's parameters, whether it takes any number, its file and its line.
local function parameters(called)
    local info = getinfo(called, "uS")
    if info.what == "C" then return nil end
    local names = {}
    for rank = 1, info.nparams do names[rank] = getlocal(called, rank) end
    return names, info.isvararg, (info.source:gsub("^[@=]", "")), info.linedefined
end

local port = {}

function port.read(self)
    local failure = raw.take(self)
    if failure then error(failure, 0) end
    return raw.data(self)
end

function port.latest(self)
    if raw.take(self) then return nil end
    return raw.data(self)
end

function port.write(self, ...)
    if select("#", ...) > 0 then raw.set(self, (...)) end
    local failure = raw.publish(self)
    if failure then error(failure, 0) end
end

function port.at(self, name) return raw.at(self, name) end

function port.open(self, name)
    local failure = raw.open(self, name)
    if failure then error(failure, 0) end
end

function port.close(self, name)
    local failure = raw.close(self, name)
    if failure then error(failure, 0) end
end

local function port_index(self, key)
    if key == "data" then return raw.data(self) end
    return port[key] or error("a port has no `" .. tostring(key) .. "`", 2)
end

local function port_newindex(self, key, value)
    if key ~= "data" then error("a port has no `" .. tostring(key) .. "`", 2) end
    raw.set(self, value)
end

-- What coroutines yield for the runner: it calls the service while other codels run.
local MARK = {}

local function remote_call(remote, inputs)
    local failure, outputs = yield(MARK, raw.prepare(remote, inputs or {}))
    if failure then error(failure, 0) end
    return outputs
end

-- Coroutines of scripts pass on what is for the runner.
local function through(coroutine, ok, first, ...)
    if ok and first == MARK then return through(coroutine, resume(coroutine, yield(MARK, ...))) end
    return ok, first, ...
end

local function returned(ok, first, ...)
    if not ok then error(first, 0) end
    return first, ...
end

function coroutine.resume(coroutine, ...) return through(coroutine, resume(coroutine, ...)) end

function coroutine.wrap(body)
    local made = create(body)
    return function(...) return returned(through(made, resume(made, ...))) end
end

function os.exit() error("os.exit would end the cell: a codel returns its event", 2) end

-- What could break this is not for scripts.
for name in pairs(debug) do
    if name ~= "getinfo" and name ~= "traceback" then debug[name] = nil end
end
io.stdout:setvbuf("line")

package.preload.genom = function()
    return { copy = raw.copy, resize = raw.resize, event = event_of }
end

return {
    mark = MARK, failed = failed, class = class, parameters = parameters, xpcall = xpcall,
    port_index = port_index, port_newindex = port_newindex, remote_call = remote_call,
}

// Parts of bodies and streams, at a gateway in memory.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using Newtonsoft.Json.Linq;
using OpenRoIS;
using OpenRoIS.Components;

public static class BodyPartTests
{
    public static async Task AnOptionalPartIsLostAloneAndARequiredOneWithTheBody()
    {
        var place = new Place();
        var losses = new Feed<string>(10);
        place.Client.BodyLost += loss => losses.Offer(loss.EngineId + " " + loss.ComponentRef);
        place.Gateway.Answers["rois.system.get_profile"] = given => Profile();
        place.Gateway.Answers["rois.command.bind"] = given => ScriptedGateway.Ok();
        await place.Client.ConnectAsync();
        var request = new BodyRequest(Navigation.Type) { Optional = new ComponentType[] { Reaction.Type, Follow.Type } };
        Body body = await place.Client.BodyAsync(request);
        Check.Equal("robot", body.EngineId);
        Check.Equal("robot/reaction", body.Find(Reaction.Type).ComponentRef);
        Check.True(body.Find(Follow.Type) == null, "there is none");
        Take(place, "robot/reaction");
        await place.Settle();
        Check.True(body.Find(Reaction.Type) == null, "it is lost");
        Check.True(body.Error == null, "the body is not");
        Take(place, "robot/navigation");
        Check.True(await losses.MoveNextAsync(), "it is told");
        Check.Equal("robot robot/navigation", losses.Current);
        Check.Equal("another application holds robot/navigation now: a test", body.Error.Message);
        // The parts that this application still has are given back.
        await place.Client.BodyAsync(Navigation.Type, Reaction.Type);
        Take(place, "robot/navigation");
        Check.Equal("robot/reaction", await Released(place));
        await place.Client.CloseAsync();
    }

    public static async Task ABodyThatIsGivenUpHalfWayIsHeldByNothing()
    {
        var place = new Place();
        place.Gateway.Answers["rois.system.get_profile"] = given => Profile();
        await place.Client.ConnectAsync();
        using (var soon = new CancellationTokenSource())
        {
            Task<Body> reserving = place.Client.BodyAsync(new BodyRequest(Navigation.Type, Reaction.Type), soon.Token);
            place.Gateway.Answer(await place.Gateway.RequestAsync("rois.command.bind"), ScriptedGateway.Ok());
            JObject second = await place.Gateway.RequestAsync("rois.command.bind");
            soon.Cancel();
            await Check.ThrowsAsync<OperationCanceledException>(() => reserving);
            Check.Equal("robot/navigation", await Released(place));
            place.Gateway.Answer(second, ScriptedGateway.Ok());
            Check.Equal("robot/reaction", await Released(place));
        }
        await place.Client.CloseAsync();
    }

    private static async Task<string> Released(Place place)
    {
        return (string)(await place.Gateway.RequestAsync("rois.command.release"))["params"]["component_ref"];
    }

    private static void Take(Place place, string componentRef)
    {
        place.Gateway.Notify("openrois.lease.changed", new JObject(
            new JProperty("component_ref", componentRef), new JProperty("state", "HELD"), new JProperty("reason", "a test")));
    }

    private static JObject Profile()
    {
        var components = new JObject();
        foreach (KeyValuePair<string, ComponentType> each in new Dictionary<string, ComponentType>
        {
            { "robot/navigation", Navigation.Type }, { "robot/reaction", Reaction.Type }
        })
        {
            components[each.Key] = new JObject(
                new JProperty("identifier", new JObject(new JProperty("code", each.Value.Urn))),
                new JProperty("name", each.Key));
        }
        var robot = new JObject(
            new JProperty("identifier", new JObject(new JProperty("code", "robot"))),
            new JProperty("component_ids", new JArray("robot/navigation", "robot/reaction")));
        var main = new JObject(
            new JProperty("identifier", new JObject(new JProperty("code", "gateway"))),
            new JProperty("sub_profiles", new JArray(robot)));
        return ScriptedGateway.Ok(
            new JProperty("profile", main), new JProperty("component_profiles", components));
    }
}

public static class StreamTests
{
    private const string Camera = "robot/camera";

    public static async Task AStreamThatComesAfterItWasGivenUpIsDisconnected()
    {
        var place = new Place();
        place.Gateway.Answers["openrois.hello"] =
            given => ScriptedGateway.Ok(new JProperty("extensions", new JArray("rois.stream")));
        await place.Client.ConnectAsync();
        using (var soon = new CancellationTokenSource())
        {
            Task<string> connecting = place.Client.Component(VideoStreaming.Type, Camera).ConnectStreamAsync(token: soon.Token);
            JObject request = await place.Gateway.RequestAsync("rois.stream.connect_stream");
            soon.Cancel();
            await Check.ThrowsAsync<OperationCanceledException>(() => connecting);
            place.Gateway.Answer(request, ScriptedGateway.Ok(new JProperty("stream_id", "late")));
            JObject undone = await place.Gateway.RequestAsync("rois.stream.disconnect_stream");
            Check.Equal("late", (string)undone["params"]["stream_id"]);
        }
        await place.Client.CloseAsync();
    }

    public static async Task InStrictRoISSuchAStreamIsDisconnectedByACommand()
    {
        var place = new Place();
        await place.Client.ConnectAsync();
        using (var soon = new CancellationTokenSource())
        {
            Task<string> connecting = place.Client.Component(VideoStreaming.Type, Camera).ConnectStreamAsync(token: soon.Token);
            JObject request = await place.Gateway.RequestAsync("rois.command.execute");
            place.Gateway.Answer(request, ScriptedGateway.Ok());
            await place.Settle();
            soon.Cancel();
            await Check.ThrowsAsync<OperationCanceledException>(() => connecting);
            place.Gateway.Notify("rois.command.completed", new JObject(
                new JProperty("command_id", request["params"]["command_unit_list"][0]["command_id"]),
                new JProperty("status", "OK")));
            JObject asked = await place.Gateway.RequestAsync("rois.command.get_command_result");
            place.Gateway.Answer(asked, ScriptedGateway.Ok(new JProperty("results", new JArray(new JObject(
                new JProperty("name", "stream_id"), new JProperty("data_type_ref", "string"), new JProperty("value", "late"))))));
            JToken undone = (await place.Gateway.RequestAsync("rois.command.execute"))["params"]["command_unit_list"][0];
            Check.Equal("disconnect_stream", (string)undone["command_type"]);
            Check.Equal("late", (string)undone["arguments"][0]["value"]);
        }
        await place.Client.CloseAsync();
    }
}

using System;
using System.IO;
using System.Linq;
using Newtonsoft.Json.Linq;
using OpenRoIS;

public static class ValueTests
{
    public static void EveryValidValueIsReadAndWrittenAsTheSame()
    {
        foreach (JToken each in Corpus("valid"))
        {
            var code = (string)each["type"];
            object value = Values.Decode(code, (string)each["text"]);
            Check.True(Same(each["value"], JToken.FromObject(value)), each.ToString());
            // Stream_Status takes any text when it is read, and names alone when it is written.
            if (code != "Stream_Status")
            {
                object again = Values.Decode(code, Values.Encode(code, value));
                Check.True(Same(each["value"], JToken.FromObject(again)), each.ToString());
            }
        }
    }

    public static void EveryInvalidValueIsRefused()
    {
        foreach (JToken each in Corpus("invalid"))
        {
            try
            {
                Values.Decode((string)each["type"], (string)each["text"]);
            }
            catch (FormatException)
            {
                continue;
            }
            throw new Exception(each.ToString());
        }
    }

    public static void WhatDoesNotFitIsNotWritten()
    {
        Check.Throws<FormatException>(() => Values.Encode("int", "7"));
        Check.Throws<FormatException>(() => Values.Encode("int", 7.5));
        Check.Throws<FormatException>(() => Values.Encode("int", true));
        Check.Throws<FormatException>(() => Values.Encode("bool", 1));
        Check.Throws<FormatException>(() => Values.Encode("double", double.NaN));
        Check.Throws<FormatException>(() => Values.Encode("double", double.PositiveInfinity));
        Check.Throws<FormatException>(() => Values.Encode("string", 7));
        Check.Throws<FormatException>(() => Values.Encode("string[]", "text"));
        Check.Throws<FormatException>(() => Values.Encode("string[]", new object[] { "a", null }));
        Check.Throws<FormatException>(() => Values.Encode("stream_status", "RUNNING"));
        Check.Throws<FormatException>(() => Values.Encode("string", new object()));
    }

    public static void ValuesOfTheProgramAreWrittenAsTheWireHasThem()
    {
        Check.Equal("7", Values.Encode("int", 7));
        Check.Equal("7", Values.Encode("long", (short)7));
        Check.Equal("0.5", Values.Encode("double", 0.5f));
        Check.Equal("7", Values.Encode("double", 7L));
        Check.Equal("true", Values.Encode("boolean", true));
        Check.Equal("READY", Values.Encode("Component_Status", ComponentStatus.Ready));
        Check.Equal("STREAMING_RUNNING", Values.Encode("Stream_Status", StreamStatus.StreamingRunning));
        Check.Equal("[\"a\",\"b\"]", Values.Encode("string[]", new[] { "a", "b" }.Select(each => each)));
        Check.Equal("[[1],[2,3]]", Values.Encode("int[][]", new[] { new[] { 1 }, new[] { 2, 3 } }));
        var moment = new DateTimeOffset(2026, 6, 1, 12, 0, 0, TimeSpan.FromHours(2));
        Check.Equal(moment, Values.DecodeMoment(Values.Encode("DateTime", moment)));
    }

    public static void MomentsAreThoseOfTheStandard()
    {
        var noon = new DateTimeOffset(2026, 6, 1, 12, 0, 0, TimeSpan.Zero);
        foreach (string text in new[]
        {
            "2026-06-01T12:00:00+00:00", "2026-06-01T12:00:00Z", "2026-06-01 12:00:00", "2026-06-01T14:00+02:00",
            "2026-06-01T12:00:00.000000000Z"
        })
        {
            Check.Equal(noon, Values.DecodeMoment(text));
        }
        foreach (string text in new[] { "", "2026-06-01", "12:00", "2026-13-01T12:00:00Z", "06/01/2026 12:00:00", "now" })
        {
            Check.Throws<FormatException>(() => Values.DecodeMoment(text));
        }
    }

    private static JArray Corpus(string kind)
    {
        return (JArray)JsonRpcMessage.Parse(File.ReadAllText(Program.ValuesFile))[kind];
    }

    private static bool Same(JToken one, JToken other)
    {
        if (one is JArray && other is JArray)
        {
            return one.Count() == other.Count() && one.Zip(other, Same).All(each => each);
        }
        bool numbers = (one.Type == JTokenType.Integer || one.Type == JTokenType.Float)
            && (other.Type == JTokenType.Integer || other.Type == JTokenType.Float);
        return numbers ? (double)one == (double)other : JToken.DeepEquals(one, other);
    }
}
